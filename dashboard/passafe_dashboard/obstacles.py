"""Barriers of a scenario in plain numbers: h as measured, and what there is to draw of them.

Evaluating h from a plant state needs nothing of the filter, so the page can show what the filter believes beside what
the robot did. A state begins with the coordinates of all positions, followed by those of all velocities.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import ClassVar, TypeAlias

from passafe_services.scenarios.barrier_schema import ApartBarrier, DiskBarrier, EllipseBarrier, Motion, SpeedBarrier
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.single_barriers import POINTS, CoordinateLimit, SingleBarrier

from passafe_dashboard.motion import displacement


@dataclass(frozen=True, kw_only=True, slots=True)
class Disk:
    """A disk that a point keeps out of: h = ‖p − centre‖² − radius², m²; that it stays in: −h.

    Attributes:
        name: The barrier's.
        centre: Where it is before it has moved, m.
        radius: m.
        keep_in: Whether it is to stay in.
        motion: How it moves.
        first: Place of the point's position in the state.
    """

    name: str
    centre: tuple[float, ...]
    radius: float
    keep_in: bool = False
    motion: Motion | None = None
    first: int = 0
    unit: ClassVar[str] = "m²"

    def h(self, x: Sequence[float], t_s: float = 0.0) -> float:
        """Barrier value at a state and a plant time, m²."""
        d1, d2 = displacement(self.motion, t_s)
        e1 = x[self.first] - d1 - self.centre[0]
        e2 = x[self.first + 1] - d2 - self.centre[1]
        outside = e1 * e1 + e2 * e2 - self.radius * self.radius
        return -outside if self.keep_in else outside


@dataclass(frozen=True, kw_only=True, slots=True)
class Ellipse:
    """An ellipse that a point keeps out of, or stays in; see ``passafe.barriers.ellipse`` for its h, m².

    Attributes:
        name: The barrier's.
        centre: Where it is before it has moved, m.
        semi_axes: m.
        rotation_rad: From the first coordinate to the first semi-axis, counter-clockwise.
        keep_in: Whether it is to stay in.
        motion: How it moves.
        first: Place of the point's position in the state.
    """

    name: str
    centre: tuple[float, ...]
    semi_axes: tuple[float, ...]
    rotation_rad: float = 0.0
    keep_in: bool = False
    motion: Motion | None = None
    first: int = 0
    unit: ClassVar[str] = "m²"

    def h(self, x: Sequence[float], t_s: float = 0.0) -> float:
        """Barrier value at a state and a plant time, m²."""
        d1, d2 = displacement(self.motion, t_s)
        e1 = x[self.first] - d1 - self.centre[0]
        e2 = x[self.first + 1] - d2 - self.centre[1]
        c, s = cos(self.rotation_rad), sin(self.rotation_rad)
        a1, a2 = self.semi_axes
        shortest = min(a1, a2)
        w1, w2 = (c * e1 + s * e2) * shortest / a1, (c * e2 - s * e1) * shortest / a2
        outside = w1 * w1 + w2 * w2 - shortest * shortest
        return -outside if self.keep_in else outside


@dataclass(frozen=True, kw_only=True, slots=True)
class HalfPlane:
    """A side of a line that a point stays on: h = normalᵀp − offset; m when the normal has unit length.

    Attributes:
        name: The barrier's.
        normal: Into the half-plane.
        offset: Of the line before it has moved.
        motion: How it moves.
        first: Place of the point's position in the state.
    """

    name: str
    normal: tuple[float, ...]
    offset: float
    motion: Motion | None = None
    first: int = 0
    unit: ClassVar[str] = "m"

    def h(self, x: Sequence[float], t_s: float = 0.0) -> float:
        """Barrier value at a state and a plant time."""
        d1, d2 = displacement(self.motion, t_s)
        n1, n2 = self.normal
        return n1 * (x[self.first] - d1) + n2 * (x[self.first + 1] - d2) - self.offset


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedLimit:
    """A speed that a point stays below: h = limit² − ‖v‖², (m/s)².

    Attributes:
        name: The barrier's.
        limit: m/s.
        first: Place of the point's velocity in the state.
    """

    name: str
    limit: float
    first: int
    unit: ClassVar[str] = "m²/s²"

    def h(self, x: Sequence[float], _t_s: float = 0.0) -> float:
        """Barrier value at a state, (m/s)²."""
        v1, v2 = x[self.first], x[self.first + 1]
        return self.limit * self.limit - v1 * v1 - v2 * v2


@dataclass(frozen=True, kw_only=True, slots=True)
class Separation:
    """A distance that two points keep: h = ‖p₁ − p₂‖² − distance², m².

    Attributes:
        name: The barrier's.
        distance: m.
    """

    name: str
    distance: float
    unit: ClassVar[str] = "m²"

    def h(self, x: Sequence[float], _t_s: float = 0.0) -> float:
        """Barrier value at a state, m²."""
        e1, e2 = x[0] - x[2], x[1] - x[3]
        return e1 * e1 + e2 * e2 - self.distance * self.distance


@dataclass(frozen=True, kw_only=True, slots=True)
class Limit:
    """One side of the limits of one coordinate: h = q − bound, or bound − q where it is the upper one.

    Attributes:
        name: The barrier's.
        place: Of q in the state.
        bound: In q's unit.
        upper: Whether q stays below it.
        unit: Of q.
    """

    name: str
    place: int
    bound: float
    upper: bool
    unit: str

    def h(self, x: Sequence[float], _t_s: float = 0.0) -> float:
        """Barrier value at a state, in the coordinate's unit."""
        above = x[self.place] - self.bound
        return -above if self.upper else above


Region: TypeAlias = Disk | Ellipse | HalfPlane
"""What there is to draw in the plane."""

Obstacle: TypeAlias = Region | SpeedLimit | Separation | Limit


def obstacles_of(scenario: Scenario) -> tuple[Obstacle, ...]:
    """Every barrier of a scenario, in the scenario's order."""
    points = POINTS[scenario.plant.model]
    coordinates = 2 * points or len(scenario.plant.x0) // 2
    return tuple(_obstacle(barrier, coordinates, points > 0) for barrier in scenario.barriers)


def _obstacle(barrier: SingleBarrier, coordinates: int, in_the_plane: bool) -> Obstacle:
    if isinstance(barrier, CoordinateLimit):
        of_velocity = barrier.of == "velocity"
        unit = ("m" if in_the_plane else "rad") + ("/s" if of_velocity else "")
        place = barrier.index + (coordinates if of_velocity else 0)
        return Limit(name=barrier.name, place=place, bound=barrier.bound, upper=barrier.upper, unit=unit)
    if isinstance(barrier, ApartBarrier):
        return Separation(name=barrier.name, distance=barrier.distance_m)
    first = 2 * ((barrier.point or 1) - 1)
    if isinstance(barrier, SpeedBarrier):
        return SpeedLimit(name=barrier.name, limit=barrier.limit_m_per_s, first=coordinates + first)
    if isinstance(barrier, DiskBarrier):
        return Disk(
            name=barrier.name,
            centre=barrier.centre,
            radius=barrier.radius,
            keep_in=barrier.kind == "disk-keep-in",
            motion=barrier.motion,
            first=first,
        )
    if isinstance(barrier, EllipseBarrier):
        return Ellipse(
            name=barrier.name,
            centre=barrier.centre,
            semi_axes=barrier.semi_axes_m,
            rotation_rad=barrier.rotation_rad,
            keep_in=barrier.kind == "ellipse-keep-in",
            motion=barrier.motion,
            first=first,
        )
    return HalfPlane(
        name=barrier.name, normal=barrier.normal, offset=barrier.offset, motion=barrier.motion, first=first
    )


def unit_of_h(obstacle: Obstacle) -> str:
    """Unit of an obstacle's h, as an axis label says it."""
    return obstacle.unit
