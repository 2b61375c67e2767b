"""Checks of a scenario before it runs: ``passafe check``, and the warnings of every command that runs one."""
