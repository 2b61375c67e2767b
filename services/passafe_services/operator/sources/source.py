"""What a source of commands is: who or what plays the operator."""

from enum import Enum
from typing import Protocol, runtime_checkable

from passafe_protocol.messages import PlantState

from passafe_services.operator.sources.command import Command


class SourceClock(Enum):
    """Whose time a source is a function of."""

    PLANT = "plant"
    """Plant time: a script begins when the robot does."""

    LOCAL = "local"
    """Time since the node's first step: a person acts before the robot moves, too."""


class Source(Protocol):
    """A source of commands: no clock, no device, only what it is handed."""

    @property
    def device(self) -> str:
        """What makes the commands: lag, constant, keyboard and so on."""
        ...

    @property
    def clock(self) -> SourceClock:
        """Whose time ``command`` is asked for."""
        ...

    @property
    def finished(self) -> bool:
        """Whether the operator wants to end the session; a script never does."""
        ...

    def command(self, t_s: float) -> Command:
        """Return what is asked for at ``t_s``.

        Args:
            t_s: Time of ``clock``, s, never negative. A source on local time is never asked about the past.
        """
        ...


@runtime_checkable
class Seeing(Protocol):
    """What a source has besides, if it closes the loop: a node shows it the robot, as far as the node knows."""

    def see(self, state: PlantState) -> None:
        """Take the newest state that has come: how the robot stood at that state's own plant time.

        It is called before the ``command`` of the same step, and only in a step in which a newer state came: not at
        all before the first one, and not while the way to the operator is cut.

        Args:
            state: The newest one; those that it overtook, or that came with it, are never shown.
        """
        ...
