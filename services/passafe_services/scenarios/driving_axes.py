"""Axes of the input that a person commands from a page: their authority, and which of them form a plane."""

from dataclasses import dataclass
from typing import Final

from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import KeyboardSource

AUTHORITY: Final = KeyboardSource(kind="keyboard").authority
"""Largest |u_h| that one axis commands where the limits leave that much, units of u: that of a keyboard."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DrivingAxes:
    """Axes of the input for a joystick.

    Attributes:
        full: Largest |u_h| of each axis, units of u.
        planes: Axes that one joystick commands: two, or the one that is left over.
        names: Name of each plane.
    """

    full: tuple[float, ...]
    planes: tuple[tuple[int, ...], ...]
    names: tuple[str, ...]

    @classmethod
    def of(cls, scenario: Scenario) -> "DrivingAxes":
        """Return the axes of a scenario: at most half the range that its limits leave to an axis is commanded.

        Raises:
            DesignError: Limits of another number of axes than the robot has.
        """
        model = scenario.plant.robot_model
        points = model.points
        m = model.commands or (2 * points if points else len(scenario.plant.x0) // 2)
        robot = scenario.plant.robot
        planes = tuple(tuple(range(first, min(first + 2, m))) for first in range(0, m, 2))
        if robot is not None and robot.inputs != m:  # in a frame of its own, whose coordinates have no limits
            words = robot.axes or tuple(str(axis + 1) for axis in range(m))
            names = tuple(" and ".join(words[axis] for axis in plane) for plane in planes)
            return cls(full=(AUTHORITY,) * m, planes=planes, names=names)
        limits = scenario.filter.limits(m)
        full = tuple(min(AUTHORITY, (high - low) / 2) for low, high in zip(limits.low, limits.high, strict=True))
        axes = () if scenario.plant.robot is None else scenario.plant.robot.axes
        return cls(full=full, planes=planes, names=tuple(_name(plane, points, axes) for plane in planes))


def _name(plane: tuple[int, ...], points: int, axes: tuple[str, ...]) -> str:
    if points:
        return "robot" if points == 1 else f"robot {plane[0] // 2 + 1}"
    if axes:
        return " and ".join(axes[axis] for axis in plane)
    numbers = [str(axis + 1) for axis in plane]
    return f"joints {' and '.join(numbers)}" if len(numbers) > 1 else f"joint {numbers[0]}"
