"""How far a state is from a barrier's limit, in the unit of what the barrier is written in."""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.models.robot import Robot
from passafe.workspace import Array

_FLAT: Final = 1e-9
"""Slope of h below which it says nothing of a distance."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Reading:
    """What a gauge shows.

    Attributes:
        value: Distance to the limit to first order, h/‖∂h/∂x‖; h itself where ``unit`` is empty.
        unit: m or m/s, or empty.
    """

    value: float
    unit: str


class BarrierDistance:
    """Reads h(x, t)/‖∂h/∂x‖, the distance to {h = 0} to first order in itself.

    For a disk it is (ρ² − r²)/2ρ at distance ρ from the centre, which misses ρ − r by (ρ − r)²/2ρ.

    Attributes:
        is_obstacle: Whether h is a function of places, and perhaps of time, alone.
    """

    def __init__(self, chain: BarrierChain, robot: Robot) -> None:
        """Derive and compile.

        Args:
            chain: The barrier's, on the robot's system.
            robot: Says which coordinates of x are places, which velocities.
        """
        h, x, t = chain.barrier.h, robot.system.x, robot.system.t
        used = _coordinates(h, x)
        places, velocities = _coordinates(robot.position, x), _coordinates(robot.velocity, x)
        self.is_obstacle = robot.points > 0 and used <= places
        self._unit = "m" if self.is_obstacle else "m/s" if robot.points > 0 and used <= velocities else ""
        self._function = ca.Function("gauge", [x, t], [h, ca.norm_2(ca.densify(ca.gradient(h, x)))])

    def read(self, x: Array, t_s: float) -> Reading:
        """Return the reading at a state and a plant time."""
        h, slope = (float(value) for value in self._function(x, t_s))
        if self._unit and slope > _FLAT and isfinite(h / slope):
            return Reading(value=h / slope, unit=self._unit)
        return Reading(value=h, unit="")


def _coordinates(expression: ca.SX, x: ca.SX) -> set[int]:
    """Return the places in x of what an expression depends on."""
    return {i for i in range(x.numel()) if ca.depends_on(expression, x[i])}
