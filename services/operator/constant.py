"""The same command throughout."""

from dataclasses import dataclass
from typing import ClassVar

from protocol.messages import Vector
from services.operator.source import Command, SourceClock


@dataclass(frozen=True, kw_only=True, slots=True)
class Constant:
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
