"""A person at the keyboard of a terminal."""
