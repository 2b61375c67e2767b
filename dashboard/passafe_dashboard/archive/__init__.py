"""Logs and experiments in the runs folder, as the page lists them."""
