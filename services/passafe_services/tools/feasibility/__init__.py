"""Map where in the state space the filter can satisfy its constraints (``docs/feasibility.md``)."""
