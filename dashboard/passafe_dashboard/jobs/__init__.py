"""Work that takes seconds, in processes of its own beside the server: reviews, comparisons, re-runs."""
