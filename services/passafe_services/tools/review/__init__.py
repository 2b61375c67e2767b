"""Reviews the log of a run and gives a verdict."""
