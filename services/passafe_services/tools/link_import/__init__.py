"""Measurements of real networks as traces of delays for links."""
