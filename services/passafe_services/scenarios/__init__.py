"""Scenario files, their schema, and how they become objects of the core."""
