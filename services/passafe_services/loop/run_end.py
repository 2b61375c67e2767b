"""End of a run of supervised processes."""

from dataclasses import dataclass

from passafe_services.loop.process_exit import ExitCause


@dataclass(frozen=True, kw_only=True, slots=True)
class RunEnd:
    """End of a run and its cause.

    Attributes:
        cause: Cause of the end.
        culprit: Process that caused it, if one did.
        detail: Description in one line.
    """

    cause: ExitCause
    culprit: str | None
    detail: str
