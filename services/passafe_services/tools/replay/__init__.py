"""Replay of the filter of a logged run, to the last bit."""
