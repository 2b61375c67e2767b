"""Piecewise linear commands: waypoints of a scenario and recorded commands."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar, Self

from msgspec import Struct
from passafe_protocol.messages import Vector

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock


class PiecewiseLinear(Struct, frozen=True, kw_only=True, gc=False):
    """Linear interpolation of u_h through points, held before the first and after the last.

    u̇_h is the slope after the current point, and zero where u_h is held.

    Attributes:
        device: Origin of the points: ``waypoints`` or ``recorded``.
        times_s: Plant time of each point, s, strictly increasing, at least one.
        values: u_h at each point, units of u.
        slopes: u̇_h from each point but the last to the next one, units of u per second.
    """

    device: str
    times_s: tuple[float, ...]
    values: tuple[Vector, ...]
    slopes: tuple[Vector, ...]
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    @classmethod
    def through(cls, *, device: str, times_s: Sequence[float], values: Sequence[Vector]) -> Self:
        """Return the interpolation of ``values`` at ``times_s``.

        Args:
            device: Origin of the points.
            times_s: Plant time of each point, s, strictly increasing, at least one.
            values: u_h at each point, all of one length.
        """
        slopes = tuple(
            tuple([(b - a) / (end - start) for a, b in zip(left, right, strict=True)])
            for (start, end), (left, right) in zip(pairwise(times_s), pairwise(values), strict=True)
        )
        return cls(device=device, times_s=tuple(times_s), values=tuple(values), slopes=slopes)

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        following = bisect_right(self.times_s, t_s)
        if following == 0:
            return self._held(self.values[0])
        if following == len(self.times_s):
            return self._held(self.values[-1])
        since_s = t_s - self.times_s[following - 1]
        slope = self.slopes[following - 1]
        u_h = [c + s * since_s for c, s in zip(self.values[following - 1], slope, strict=True)]
        return Command(tuple(u_h), slope, True)

    @staticmethod
    def _held(value: Vector) -> Command:
        return Command(value, (0.0,) * len(value), True)
