"""Errors of re-running a log; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError
from passafe_services.tools.review.errors import ReviewError


class RerunError(ReviewError):
    """A log whose run cannot be repeated."""


class ChangeError(NotAllowedError):
    """A change that cannot be made to a run; ``field`` names it as typed."""
