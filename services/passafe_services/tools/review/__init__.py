"""Reads a run's log and judges it."""
