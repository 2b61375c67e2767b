"""The quadratic program of a decision: its numbers, where it is solved, and how far it is from a conflict."""
