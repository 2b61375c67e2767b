"""Errors of reviewing a log; the tree of all errors is in ``passafe.errors``."""

from passafe_services.log.errors import LogFileError


class ReviewError(LogFileError):
    """A readable log that cannot be reviewed."""


class ScenarioRecordError(ReviewError):
    """A log that does not state its scenario, or not in a way that this build reads."""


class MismatchedLogError(ReviewError):
    """A log whose messages do not fit its own scenario."""
