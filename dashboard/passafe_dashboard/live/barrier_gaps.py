"""Distances to barriers as a person reads them: metres to a wall, not h, and in which direction it lies."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from typing import Final

import casadi as ca
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.schema import Scenario

from passafe_dashboard.live.moved_quantity import POSITION, VELOCITY, MovedQuantity
from passafe_dashboard.run_record.signals import PURE_NUMBER

_TINY: Final = 1e-12
"""Square of a slope of h below which the barrier has no direction."""

LEAST_PULL: Final = 1e-6
"""Part of a slope below which a point does not count."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Gap:
    """Distance to one barrier at a state.

    Attributes:
        name: Name of the barrier.
        distance: Distance to {h = 0}: in space where the barrier says it, else along the slope of h, which is exact for
            disks, walls, speeds; < 0: beyond it.
        unit: Its unit: m, m/s, rad or rad/s. Where the barrier is of neither position nor velocity alone, the distance
            is h itself, in its unit.
        towards: Unit vector of the plane in which position or velocity comes nearer to the barrier; zero without one.
        point: Number of the point that it is about, from 0.
        pulls: For each point of the plane, its part of the unit vector along which h falls fastest; (0, 0) for the
            points that it is not about, and for joints.
    """

    name: str
    distance: float
    unit: str
    towards: tuple[float, float]
    point: int
    pulls: tuple[tuple[float, float], ...]


class BarrierGaps:
    """Evaluates the gap to every barrier of a scenario.

    h is followed from the state along its slope, to second order: s with h − |∇h|s + ½(nᵀ∇²h n)s² = 0. For a barrier
    of two points that is the way of the first one alone.

    Args:
        scenario: The scenario.

    Raises:
        ScenarioError: Its model does not take its parameters or its x0.
        DesignError: A barrier or a parameter that the robot cannot have.
    """

    def __init__(self, scenario: Scenario) -> None:
        robot = robot_of(scenario)
        unit = scenario.plant.robot_model.position_unit
        units = {POSITION: unit, VELOCITY: f"{unit}/s"}
        self._states = robot.system.x.numel()
        self._points = robot.points
        parts, self._about = [], []
        for single, barrier in zip(scenario.barriers, barriers_of(scenario, robot), strict=True):
            moved, own = MovedQuantity.of(robot, barrier.h), single.distance(robot)
            point = 0
            if moved is None:
                distance, in_unit = barrier.h, "" if single.h_unit == PURE_NUMBER else single.h_unit
                pulls = ca.SX.zeros(2 * robot.points)
            else:
                point = moved.first_point(robot.points)
                distance, in_unit = _distance(barrier.h, moved, point, robot.points), units[moved.name]
                pulls = _pulls(moved, 2 * robot.points)
            self._about.append((single.name, in_unit if own is None else "m", point))
            parts += [distance if own is None else own, pulls]
        stacked = ca.vertcat(ca.SX(0, 1), *parts)
        self._function = ca.Function("gaps", [robot.system.x, robot.system.t], [ca.densify(stacked)])

    def read(self, x: Sequence[float], t_s: float) -> list[Gap]:
        """Return the gap to every barrier, in the scenario's order.

        Args:
            x: State that begins with the scenario's, n numbers or more.
            t_s: Plant time, s.
        """
        if not self._about:
            return []
        values: list[float] = self._function(list(x[: self._states]), t_s).elements()
        width = 1 + 2 * self._points
        return [self._gap(about, values[i * width : (i + 1) * width]) for i, about in enumerate(self._about)]

    def _gap(self, about: tuple[str, str, int], values: Sequence[float]) -> Gap:
        name, unit, point = about
        pulls = tuple((values[1 + 2 * i], values[2 + 2 * i]) for i in range(self._points))
        along = pulls[point] if pulls else (0.0, 0.0)
        size = hypot(*along)
        towards = (along[0] / size, along[1] / size) if size > LEAST_PULL else (0.0, 0.0)
        return Gap(name=name, distance=values[0], unit=unit, towards=towards, point=point, pulls=pulls)


def _distance(h: ca.SX, moved: MovedQuantity, point: int, points: int) -> ca.SX:
    """Return the way along the slope of h to h = 0, to second order."""
    rows = slice(2 * point, 2 * point + 2) if points else slice(0, moved.slope.numel())
    bend, slope = moved.bend[rows, rows], moved.slope[rows]
    square = ca.dot(slope, slope)
    # Where h is flat, as at the centre of a disk, the mean bend decides instead of that along the slope.
    mean = ca.trace(bend) / ca.fmax(ca.trace(moved.reached[rows, rows]), _TINY)
    along = (ca.bilin(bend, slope, slope) + _TINY * mean) / (square + _TINY)
    root = ca.sqrt(ca.fmax(square - 2 * along * h, 0))
    return 2 * h / (ca.sqrt(square) + root + _TINY)


def _pulls(moved: MovedQuantity, count: int) -> ca.SX:
    """Return the unit vector along which h falls fastest, its first ``count`` numbers."""
    unit = -moved.slope / (ca.norm_2(moved.slope) + _TINY)
    return ca.reshape(unit[:count], count, 1)  # of a scalar, no rows would be a row of nothing
