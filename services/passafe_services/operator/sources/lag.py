"""A first-order lag from rest to a target."""

from math import exp, expm1
from typing import ClassVar

from msgspec import Struct
from passafe_protocol.messages import Vector

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock


class Lag(Struct, frozen=True, kw_only=True, gc=False):
    """u_h = target·(1 − e^{−t/T}), u̇_h = target·e^{−t/T}/T.

    Attributes:
        target: Where u_h tends to, units of u.
        time_constant_s: T, s, positive.
    """

    target: Vector
    time_constant_s: float
    device: ClassVar[str] = "lag"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        exponent = -t_s / self.time_constant_s
        # expm1 avoids cancellation in the first milliseconds.
        reached = -expm1(exponent)
        slope = exp(exponent) / self.time_constant_s
        u_h, rate = [], []
        for goal in self.target:  # one loop: two comprehensions cost 50 % more
            u_h.append(goal * reached)
            rate.append(goal * slope)
        return Command(tuple(u_h), tuple(rate), True)
