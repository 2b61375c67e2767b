"""The router process: every message passes through it."""
