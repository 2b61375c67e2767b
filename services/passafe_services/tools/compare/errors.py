"""Errors of comparing runs; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError


class AlignmentError(NotAllowedError):
    """Runs that cannot be aligned as asked."""
