"""Constant command."""

from typing import ClassVar

from msgspec import Struct
from passafe_protocol.messages import Vector

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock


class Constant(Struct, frozen=True, kw_only=True, gc=False):
    """u_h = value, u̇_h = 0.

    Attributes:
        value: u_h, units of u.
    """

    value: Vector
    device: ClassVar[str] = "constant"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def command(self, t_s: float) -> Command:
        """Return the command, the same at every plant time ``t_s``."""
        del t_s
        return Command(self.value, (0.0,) * len(self.value), True)
