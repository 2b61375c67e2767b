"""Errors of the command line; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError


class OptionError(NotAllowedError):
    """An option whose value cannot be used here; the field is its name as typed."""
