"""Errors of reviewing a log.

* ``ReviewError``
    * ``UnreadableLogError``: missing, empty, no MCAP file
    * ``ForeignLogError``: an MCAP file, but not of a run of passafe
    * ``ScenarioRecordError``: a run of passafe whose scenario this build cannot read
    * ``MismatchedLogError``: a run of passafe whose messages do not fit its own scenario
"""

from pathlib import Path


class ReviewError(Exception):
    """A file that cannot be reviewed.

    Attributes:
        path: The file.
        reason: Why not, in words.
    """

    def __init__(self, path: Path, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(f"{path}: {reason}")


class UnreadableLogError(ReviewError):
    """The file is missing, empty or no MCAP file."""


class ForeignLogError(ReviewError):
    """An MCAP file without a channel of passafe."""


class ScenarioRecordError(ReviewError):
    """The log does not say which scenario it is of, or says it in a way that this build does not read."""


class MismatchedLogError(ReviewError):
    """The messages in the log do not fit the scenario that it says it is of."""
