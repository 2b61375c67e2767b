"""Comparison of runs, each from its log."""
