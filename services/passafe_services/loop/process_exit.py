"""What a supervisor is given, and what it tells at the end."""

import signal
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

GRACE_S: Final = 3.0
"""How long a process may take to end before it is killed, unless its specification says otherwise."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Restarts:
    """How often a process that died is started again; the next death after that ends the run.

    Attributes:
        most: How many times within ``within_s``.
        within_s: Length of the stretch of time that counts, s.
    """

    most: int = 5
    within_s: float = 60.0


@dataclass(frozen=True, kw_only=True, slots=True)
class ProcessSpec:
    """A process to run.

    It must print ``ready_line(name)`` on standard output once it is ready, and end on SIGTERM and when its
    standard input, the lifeline, ends.

    Attributes:
        name: Its name, unique in a run; every line that it prints gets it as a prefix.
        argv: The program and its arguments.
        grace_s: How long it may take to end before it is killed.
        restarts: How often it is started again when it dies; ``None``: its death ends the run.
    """

    name: str
    argv: tuple[str, ...]
    grace_s: float = GRACE_S
    restarts: Restarts | None = None


class ExitCause(Enum):
    """What ended a supervised run."""

    DURATION = "duration"
    """The time was up."""

    SIGNAL = "signal"
    """Somebody asked for the end: Ctrl-C, SIGTERM or SIGHUP."""

    LEFT = "left"
    """A process ended by itself, with exit code 0."""

    DIED = "died"
    """A process ended by itself in any other way, and was not to be started again."""

    NOT_READY = "not ready"
    """A process was not ready in time."""

    NOT_STARTED = "not started"
    """A process could not be started."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Exit:
    """How one process ended.

    Attributes:
        name: Its name.
        returncode: Exit code, or the negative number of the signal that killed it.
        asked: Whether it ended because the supervisor had asked it to.
        forced: Whether the supervisor had to kill it.
        restarted: Whether the supervisor started it again after that.
        ready: Whether it had ever said that it was ready.
    """

    name: str
    returncode: int
    asked: bool
    forced: bool
    restarted: bool = False
    ready: bool = True

    @property
    def well(self) -> bool:
        """Whether it stopped as it should; what is not ready yet may know no better than to die of SIGTERM."""
        if self.asked and not self.forced and not self.ready and self.returncode == -signal.SIGTERM:
            return True
        return self.returncode == 0

    @property
    def how(self) -> str:
        """In words: ``exit code 1``, ``killed by SIGKILL``."""
        if self.returncode >= 0:
            return f"exit code {self.returncode}"
        try:
            return f"killed by {signal.Signals(-self.returncode).name}"
        except ValueError:  # a real-time signal has no name
            return f"killed by signal {-self.returncode}"


@dataclass(frozen=True, kw_only=True, slots=True)
class RunOutcome:
    """How a supervised run ended; none of its processes is left.

    Attributes:
        cause: What ended it.
        culprit: The process that ended it, if one did.
        detail: In words, one line.
        exits: How each process that was started ended, in the order in which they ended.
    """

    cause: ExitCause
    culprit: str | None
    detail: str
    exits: tuple[Exit, ...]

    @property
    def died(self) -> tuple[Exit, ...]:
        """Processes that ended by themselves, and not with exit code 0."""
        return tuple(end for end in self.exits if not end.asked and end.returncode != 0)

    @property
    def restarts(self) -> Mapping[str, int]:
        """How often each process was started again, by name; one that never was is left out."""
        return Counter(end.name for end in self.exits if end.restarted)

    @property
    def clean(self) -> bool:
        """Whether it ended as it should: none had to be killed, none failed to stop well, and none died for good."""
        meant = self.cause in {ExitCause.DURATION, ExitCause.SIGNAL, ExitCause.LEFT}
        return meant and all(end.well or end.restarted for end in self.exits)
