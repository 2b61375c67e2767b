"""Solvers of the filter's quadratic program, one a file, and the protocol that they share."""
