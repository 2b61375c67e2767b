"""Makes what the core's tests share importable from the folders of its groups."""
