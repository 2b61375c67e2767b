"""A page as a command source."""
