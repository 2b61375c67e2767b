"""Barriers that a robot brings with it: ``own``."""

from typing import Literal, Self

import casadi as ca
from pydantic import model_validator

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.outline import Outline, ellipse_border
from passafe_services.scenarios.fields import Place, Positive
from passafe_services.suggestion import suggestion


class OwnBarrier(SingleBarrier):
    """A barrier of the robot itself, by the name that its maker gave it: its h may be any function of the state.

    Attributes:
        unit: Unit of h, for axis labels.
        centre: Centre of the disk as which it is drawn, m; not drawn if not given.
        radius: Its radius, m.
    """

    kind: Literal["own"]
    unit: str = ""
    centre: Place | None = None
    radius: Positive | None = None

    @model_validator(mode="after")
    def _is_drawn_whole(self) -> Self:
        if (self.centre is None) is not (self.radius is None):
            raise ValueError(f"centre, radius: got {self.centre}, {self.radius}, allowed both, or neither")
        return self

    @property
    def h_unit(self) -> str:
        """Return the unit that the file gives."""
        return self.unit

    @property
    def outline(self) -> Outline | None:
        """Return the disk as which it is drawn."""
        if self.centre is None or self.radius is None:
            return None
        return Outline.keep_out(
            ellipse_border(self.centre, (self.radius, self.radius)), (self.centre[0], self.centre[1])
        )

    def h(self, robot: Robot) -> ca.SX:
        """Return the robot's h of that name.

        Raises:
            DesignError: The robot has none of that name.
        """
        if self.name not in robot.barriers:
            names = ", ".join(robot.barriers) or "none: the robot has no barriers of its own"
            allowed = names + suggestion(self.name, robot.barriers)
            raise DesignError(f"own barrier {self.name!r}", "none of the robot", allowed)
        return robot.barriers[self.name]
