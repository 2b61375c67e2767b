"""The processes, a file each, so that one that runs does not import what only the others need.

Each has ``start(options)``.
"""
