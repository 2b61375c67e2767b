"""Scenario files: schema, loading, and construction of the core's objects."""
