"""Limits of the speed: ``speed-limit``."""

from typing import ClassVar, Literal

import casadi as ca

from passafe.barriers.speed_limit import speed_limit
from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.point_barrier import PointBarrier
from passafe_services.scenarios.fields import Positive


class SpeedBarrier(PointBarrier):
    """A speed to stay below: h = limit² − ‖v‖², (m/s)².

    Attributes:
        limit_m_per_s: Largest speed, m/s.
    """

    h_unit: ClassVar[str] = "m²/s²"
    is_of_position: ClassVar[bool] = False

    kind: Literal["speed-limit"]
    limit_m_per_s: Positive

    def h(self, robot: Robot) -> ca.SX:
        """Return h of the point's velocity.

        Raises:
            DesignError: The robot has none.
        """
        if not robot.velocity.numel():
            allowed = "a robot with a velocity; one whose speed is its input has limits of the input"
            raise DesignError(f"barrier {self.name!r}", "a limit of the speed", allowed)
        return speed_limit(self.of_point(robot.velocity), limit=self.limit_m_per_s)
