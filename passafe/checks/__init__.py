"""Checks of a design before anything moves, each a file: by its formulas, and by decisions from its start."""
