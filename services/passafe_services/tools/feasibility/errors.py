"""Errors of the feasibility atlas; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError


class FeasibilityError(NotAllowedError):
    """A map that cannot be made, because of what it was asked for."""
