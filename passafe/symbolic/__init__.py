"""From a design to compiled functions: the rows and the expressions of a decision's stages, one concept a file."""
