"""Exits of supervised processes and the outcome of a supervised run."""

import signal
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Self


class ExitCause(Enum):
    """Cause of the end of a supervised run."""

    DURATION = "duration"
    """The duration of the run was over."""

    SIGNAL = "signal"
    """A signal requested the end: SIGINT (Ctrl-C), SIGTERM or SIGHUP."""

    REQUESTED = "requested"
    """The caller requested the end of a run whose supervisor goes on."""

    LEFT = "left"
    """A process exited by itself with exit code 0."""

    DIED = "died"
    """A process died and was not to be restarted."""

    NOT_READY = "not ready"
    """A process was not ready in time."""

    NOT_STARTED = "not started"
    """A process could not be started."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Exit:
    """Exit of one process.

    Attributes:
        name: Its name.
        returncode: Exit code, or the negative number of the signal that killed it.
        requested: Whether the supervisor had requested its end.
        killed: Whether the supervisor had to kill it.
        restarted: Whether the supervisor restarted it.
        ready: Whether it had ever reported that it was ready.
        ended_on_request: Whether the caller had it killed or restarted while the run went on.
    """

    name: str
    returncode: int
    requested: bool
    killed: bool
    restarted: bool = False
    ready: bool = True
    ended_on_request: bool = False

    @property
    def clean(self) -> bool:
        """True for exit code 0 or an end on request; before it is ready, a process may also end by SIGTERM."""
        if self.ended_on_request:
            return True
        if self.requested and not self.killed and not self.ready and self.returncode == -signal.SIGTERM:
            return True
        return self.returncode == 0

    @property
    def description(self) -> str:
        """Description such as ``exit code 1`` or ``killed by SIGKILL``."""
        if self.returncode >= 0:
            return f"exit code {self.returncode}"
        try:
            return f"killed by {signal.Signals(-self.returncode).name}"
        except ValueError:  # a real-time signal has no name
            return f"killed by signal {-self.returncode}"


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


@dataclass(frozen=True, kw_only=True, slots=True)
class RunOutcome(RunEnd):
    """Outcome of a supervised run; none of its processes is left.

    Attributes:
        exits: Exit of each process that was started, in the order in which they ended.
    """

    exits: tuple[Exit, ...]

    @classmethod
    def of(cls, end: RunEnd, exits: tuple[Exit, ...]) -> Self:
        """Return the outcome of a run that has ended so."""
        return cls(cause=end.cause, culprit=end.culprit, detail=end.detail, exits=exits)

    @property
    def died(self) -> tuple[Exit, ...]:
        """Processes that ended without a request, with a non-zero exit code or by a signal."""
        return tuple(end for end in self.exits if not end.requested and end.returncode != 0)

    @property
    def restarts(self) -> Mapping[str, int]:
        """Number of restarts by process name; processes without any are omitted."""
        return Counter(end.name for end in self.exits if end.restarted)

    @property
    def killed_on_request(self) -> Mapping[str, int]:
        """Number of kills on request by process name; processes without any are omitted."""
        return Counter(end.name for end in self.exits if end.ended_on_request and end.killed)

    @property
    def clean(self) -> bool:
        """True if the end was intended and every process exited cleanly or was restarted."""
        intended = self.cause in {ExitCause.DURATION, ExitCause.SIGNAL, ExitCause.REQUESTED, ExitCause.LEFT}
        return intended and all(end.clean or end.restarted for end in self.exits)
