"""A run in the well-known schemas of Foxglove, for viewers that show it without knowing passafe."""
