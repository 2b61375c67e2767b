"""Barriers that a robot brings with it: ``own``."""

from typing import Literal

import casadi as ca

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.suggestion import suggestion


class OwnBarrier(SingleBarrier):
    """A barrier of the robot itself, by the name that its maker gave it: its h may be any function of the state.

    Attributes:
        unit: Unit of h, for axis labels.
    """

    kind: Literal["own"]
    unit: str = ""

    @property
    def h_unit(self) -> str:
        """Return the unit that the file gives."""
        return self.unit

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
