"""Distance of a state to the limit of a barrier, in the unit of its coordinates."""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.models.robot import Robot
from passafe.numerics.workspace import Array

_FLAT: Final = 1e-9
"""Slope of h below which the first-order distance is not defined."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DistanceReading:
    """Distance to the limit of a barrier.

    Attributes:
        value: First-order distance h/‖∂h/∂x‖; h itself if ``unit`` is empty.
        unit: m or m/s, or empty.
    """

    value: float
    unit: str


class BarrierDistance:
    """Evaluates h(x, t)/‖∂h/∂x‖, the first-order distance to {h = 0}.

    For a disk it is (ρ² − r²)/2ρ at distance ρ from the centre; its error is (ρ − r)²/2ρ.

    Attributes:
        is_obstacle: Whether h depends on positions, and possibly time, alone.
    """

    def __init__(self, chain: BarrierChain, robot: Robot) -> None:
        """Derive and compile.

        Args:
            chain: Chain of the barrier, on the robot's system.
            robot: Defines which coordinates of x are positions and which velocities.
        """
        h, x, t = chain.barrier.h, robot.system.x, robot.system.t
        used = _coordinates(h, x)
        positions, velocities = _coordinates(robot.position, x), _coordinates(robot.velocity, x)
        self.is_obstacle = robot.points > 0 and used <= positions
        self._unit = "m" if self.is_obstacle else "m/s" if robot.points > 0 and used <= velocities else ""
        self._function = ca.Function("distance", [x, t], [h, ca.norm_2(ca.densify(ca.gradient(h, x)))])

    def read(self, x: Array, t_s: float) -> DistanceReading:
        """Return the reading at a state and a plant time."""
        h, slope = (float(value) for value in self._function(x, t_s))
        if self._unit and slope > _FLAT and isfinite(h / slope):
            return DistanceReading(value=h / slope, unit=self._unit)
        return DistanceReading(value=h, unit="")


def _coordinates(expression: ca.SX, x: ca.SX) -> set[int]:
    """Return the indices in x of the coordinates on which an expression depends."""
    return {i for i in range(x.numel()) if ca.depends_on(expression, x[i])}
