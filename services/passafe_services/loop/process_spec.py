"""Specification of a supervised process and its restart policy."""

from dataclasses import dataclass
from typing import Final

GRACE_S: Final = 6.0
"""Default time that a process may take to end before it is killed."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RestartPolicy:
    """Limit on the restarts of a process that dies; a further death ends the run.

    Attributes:
        most: Largest number of restarts within ``within_s``.
        within_s: Length of the sliding window, s.
    """

    most: int = 5
    within_s: float = 60.0


@dataclass(frozen=True, kw_only=True, slots=True)
class ProcessSpec:
    """Process to run.

    It must print ``ready_line(name)`` on standard output once it is ready, and end on SIGTERM and when its standard
    input, the lifeline, closes.

    Attributes:
        name: Its name, unique in a run; prefix of every line that it prints.
        argv: The program and its arguments.
        epoch_option: Option that tells it the epoch of its session; empty: it has none.
        control_option: Option that tells it the file descriptor of its control channel to the supervisor; empty: it
            has none.
        grace_s: Time that it may take to end before it is killed, s.
        restarts: Policy for restarts when it dies; ``None``: its death ends the run.
    """

    name: str
    argv: tuple[str, ...]
    epoch_option: str = ""
    control_option: str = ""
    grace_s: float = GRACE_S
    restarts: RestartPolicy | None = None

    def command(self, epoch: int) -> tuple[str, ...]:
        """Return the program and its arguments for a session of this epoch."""
        return (*self.argv, self.epoch_option, str(epoch)) if self.epoch_option else self.argv
