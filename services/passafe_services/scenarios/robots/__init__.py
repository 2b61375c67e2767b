"""Robots that do not come with the core: from a user's function, by entry point, and as data in scenarios and logs."""
