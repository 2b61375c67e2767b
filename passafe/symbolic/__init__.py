"""Symbolic builders: from a design to the expressions of a decision's stages, one concept a file."""
