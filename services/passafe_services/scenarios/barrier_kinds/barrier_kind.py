"""Bases of all kinds of barriers: a barrier as a scenario file states it, and a barrier with one h."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Annotated, ClassVar

import casadi as ca
from pydantic import Field

from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.outline import Outline
from passafe_services.scenarios.class_k import Chain
from passafe_services.scenarios.fields import Config
from passafe_services.scenarios.robot_models import RobotModel

Name = Annotated[str, Field(min_length=1, max_length=40)]


class BarrierKind(Config, ABC):
    """A barrier as a scenario file states it: one barrier with one h, or several.

    Attributes:
        kind: Kind of barrier.
        name: Name in rows, reports and events; each counts once.
        class_k: Class-K functions γ₁ … γ_{r+1} of its chain, r the relative degree.
        least_points: Number of points in the plane that a robot model must move to have such a barrier.
    """

    kind: str
    name: Name
    class_k: Chain
    least_points: ClassVar[int] = 0

    @abstractmethod
    def split(self, model: RobotModel) -> Iterator["SingleBarrier"]:
        """Yield barriers with one h each, every one with a name of its own.

        Args:
            model: The robot's.

        Raises:
            ValueError: The model cannot have the barrier; the text names field, got and allowed.
        """


class SingleBarrier(BarrierKind):
    """A barrier with one h."""

    @abstractmethod
    def h(self, robot: Robot) -> ca.SX:
        """Return h, a scalar expression of the robot's state and of plant time; h ≥ 0 is the safe set.

        Raises:
            DesignError: The robot has no coordinate that the barrier limits.
        """

    def derivative_bounds(self, robot: Robot) -> DerivativeBounds | None:
        """Return bounds of h's time derivatives in closed form; ``None`` where they are enclosed.

        Raises:
            DesignError: As for ``h``.
        """
        del robot
        return None

    def distance(self, robot: Robot) -> ca.SX | None:
        """Return the distance to the barrier in metres, an expression of the state; ``None`` where h itself says it."""
        del robot
        return None

    @property
    @abstractmethod
    def h_unit(self) -> str:
        """Return the unit of h, as an axis label shows it."""

    @property
    def is_of_position(self) -> bool:
        """Return whether h limits positions, so that the robot's fail-safe law takes its gains into account."""
        return True

    @property
    def outline(self) -> Outline | None:
        """Return the outline in the plane; ``None`` for a barrier that is no place."""
        return None

    def split(self, model: RobotModel) -> Iterator["SingleBarrier"]:
        """Yield the barrier itself."""
        del model
        yield self
