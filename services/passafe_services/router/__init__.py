"""The router process, which every message passes."""
