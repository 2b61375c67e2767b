"""Obstacles of a scenario as shapes in the robot's plane: what to draw, and the barrier h as measured.

A barrier of a scenario is a condition on the robot's position, which is the first part of the model's state;
see ``services/scenarios/schema.py``. Evaluating h from a plant state needs nothing of the filter, so the page
can show what the filter believes beside what the robot did.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from services.scenarios.schema import DiskBarrier, Scenario


@dataclass(frozen=True, kw_only=True, slots=True)
class Disk:
    """A disk that the robot keeps out of: h = ‖p − centre‖² − radius², m²."""

    name: str
    centre: tuple[float, ...]
    radius: float

    def h(self, position: Sequence[float]) -> float:
        """Barrier value at ``position``, a sequence that begins with the position's coordinates, m²."""
        square = 0.0
        for p, c in zip(position, self.centre, strict=False):
            square += (p - c) * (p - c)
        return square - self.radius * self.radius


@dataclass(frozen=True, kw_only=True, slots=True)
class HalfPlane:
    """A side of a line that the robot stays on: h = normalᵀp − offset; m when the normal has unit length."""

    name: str
    normal: tuple[float, ...]
    offset: float

    def h(self, position: Sequence[float]) -> float:
        """Barrier value at ``position``, a sequence that begins with the position's coordinates."""
        product = 0.0
        for p, n in zip(position, self.normal, strict=False):
            product += p * n
        return product - self.offset


Obstacle: TypeAlias = Disk | HalfPlane


def obstacles_of(scenario: Scenario) -> tuple[Obstacle, ...]:
    """Shapes of a scenario's barriers, in the scenario's order."""
    return tuple(
        Disk(name=barrier.name, centre=barrier.centre, radius=barrier.radius)
        if isinstance(barrier, DiskBarrier)
        else HalfPlane(name=barrier.name, normal=barrier.normal, offset=barrier.offset)
        for barrier in scenario.filter.barriers
    )


def unit_of_h(obstacle: Obstacle) -> str:
    """Unit of an obstacle's h, as an axis label says it."""
    return "m²" if isinstance(obstacle, Disk) else "m"
