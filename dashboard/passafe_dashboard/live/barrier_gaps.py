"""Distances to barriers as a person reads them: metres to a wall, not h, and in which direction it lies."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.schema import Scenario

from passafe.models.robot import Robot

_TINY: Final = 1e-12
"""Square of a slope of h below which the barrier has no direction."""

POSITION: Final = "position"
VELOCITY: Final = "velocity"


@dataclass(frozen=True, kw_only=True, slots=True)
class Gap:
    """Distance to one barrier at a state.

    Attributes:
        name: Name of the barrier.
        distance: Distance to {h = 0} along the slope of h, exact for disks, walls, speeds; < 0: beyond it.
        unit: Its unit: m, m/s, rad or rad/s; empty where the barrier is of neither position nor velocity alone.
        towards: Unit vector of the plane in which position or velocity comes nearer to the barrier; zero without one.
        point: Number of the point that it is about, from 0.
    """

    name: str
    distance: float
    unit: str
    towards: tuple[float, float]
    point: int


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
        self._states = robot.system.x.numel()
        parts, self._about = [], []
        for single, barrier in zip(scenario.barriers, barriers_of(scenario, robot), strict=True):
            quantity, point, coordinates = _coordinates(robot, barrier.h)
            units = {POSITION: unit, VELOCITY: f"{unit}/s", "": ""}
            self._about.append((single.name, units[quantity], point))
            parts.append(_gap(barrier.h, coordinates, planar=robot.points > 0))
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
        return [
            Gap(
                name=name,
                distance=values[3 * i],
                unit=unit,
                towards=(values[3 * i + 1], values[3 * i + 2]),
                point=point,
            )
            for i, (name, unit, point) in enumerate(self._about)
        ]


def _coordinates(robot: Robot, h: ca.SX) -> tuple[str, int, ca.SX]:
    """Return the quantity that h is about, the point, and its coordinates in x; of two points the first."""
    x = robot.system.x
    used = {i for i in range(x.numel()) if ca.depends_on(h, x[i])}
    for quantity, expression in ((POSITION, robot.position), (VELOCITY, robot.velocity)):
        places = [i for i in range(x.numel()) if ca.depends_on(expression, x[i])]
        if not used or not used <= set(places):
            continue
        if not robot.points:
            return quantity, 0, x[sorted(used)]
        point = places.index(min(used)) // 2
        return quantity, point, x[places[2 * point : 2 * point + 2]]
    return "", 0, x


def _gap(h: ca.SX, coordinates: ca.SX, *, planar: bool) -> ca.SX:
    """Return distance and direction towards the barrier, shape (3, 1)."""
    bend, slope = ca.hessian(h, coordinates)
    bend, slope = ca.densify(bend), ca.densify(slope)
    square = ca.dot(slope, slope)
    # Where h is flat, as at the centre of a disk, the mean bend decides instead of that along the slope.
    mean = ca.trace(bend) / coordinates.numel()
    along = (ca.bilin(bend, slope, slope) + _TINY * mean) / (square + _TINY)
    steepness = ca.sqrt(square)
    root = ca.sqrt(ca.fmax(square - 2 * along * h, 0))
    distance = 2 * h / (steepness + root + _TINY)
    if not planar or coordinates.numel() != 2:  # noqa: PLR2004 - the plane has two dimensions
        return ca.vertcat(distance, 0, 0)
    return ca.vertcat(distance, -slope / (steepness + _TINY))
