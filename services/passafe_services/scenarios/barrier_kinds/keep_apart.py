"""A distance between two robots: ``keep-apart``."""

from typing import ClassVar, Literal

import casadi as ca

from passafe.barriers.separation import separation
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.fields import Positive


class ApartBarrier(SingleBarrier):
    """A distance that the two robots of model ``two-points`` keep: h = ‖p₁ − p₂‖² − distance², m².

    Attributes:
        distance_m: Distance, m.
    """

    least_points: ClassVar[int] = 2
    h_unit: ClassVar[str] = "m²"

    kind: Literal["keep-apart"]
    distance_m: Positive

    def h(self, robot: Robot) -> ca.SX:
        """Return h of both positions."""
        return separation(robot.position[:2], robot.position[2:4], distance=self.distance_m)
