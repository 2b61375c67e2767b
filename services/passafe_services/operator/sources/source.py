"""Interface of command sources: scripts, devices and simulated persons."""

from enum import Enum
from typing import Protocol, runtime_checkable

from passafe_protocol.messages import PlantState

from passafe_services.operator.sources.command import Command


class SourceClock(Enum):
    """Time base of a source."""

    PLANT = "plant"
    """Plant time: a script starts with the robot."""

    LOCAL = "local"
    """Time since the node's first step: a person also acts before the robot moves."""


class CommandSource(Protocol):
    """Source of commands, without a clock or device of its own."""

    @property
    def device(self) -> str:
        """Kind of the source: lag, constant, keyboard and so on."""
        ...

    @property
    def clock(self) -> SourceClock:
        """Time base of ``command``."""
        ...

    @property
    def finished(self) -> bool:
        """True when the operator has ended the session; a script never does."""
        ...

    def command(self, t_s: float) -> Command:
        """Return the command at ``t_s``.

        Args:
            t_s: Time of ``clock``, s, not negative; non-decreasing for local time.
        """
        ...


@runtime_checkable
class ButtonSource(Protocol):
    """Source with buttons beside its command; each counts how often it was pressed so far."""

    stops: int
    """Presses of the emergency stop."""

    take_overs: int
    """Requests to take the lease over."""


@runtime_checkable
class ObservingSource(Protocol):
    """Source that closes the loop: it observes the plant states that its node receives."""

    def observe(self, state: PlantState) -> None:
        """Observe the newest state received.

        Called before the ``command`` of the same step, and only in steps that received a newer state.

        Args:
            state: The newest state; older ones of the same step and reordered ones are skipped.
        """
        ...
