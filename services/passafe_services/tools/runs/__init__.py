"""Many runs, for experiments and campaigns alike: workers, results on disk, resumption and summaries."""
