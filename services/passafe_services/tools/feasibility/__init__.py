"""The feasibility atlas: where in the state space the filter's duties can be kept at all (``docs/feasibility.md``)."""
