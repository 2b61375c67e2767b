"""Robot models that come with passafe."""
