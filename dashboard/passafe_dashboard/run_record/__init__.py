"""Record a run for its report in one pass over its messages, in memory that does not grow with the run."""
