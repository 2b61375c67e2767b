"""Barriers of the spheres that cover a robot's body: ``ball-keep-out``, ``level-keep-above``, ``spheres-apart``."""

from abc import abstractmethod
from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal, Self

import casadi as ca
from pydantic import Field, model_validator

from passafe.barriers.spheres import BoundedFunction, above_level, ball_keep_out, spheres_apart
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.errors import DesignError
from passafe.models.body_sphere import BodySphere
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import Name, SingleBarrier
from passafe_services.scenarios.fields import Finite, Positive
from passafe_services.scenarios.robot_models import RobotModel
from passafe_services.suggestion import suggestion

Spot = Annotated[tuple[Finite, ...], Field(min_length=3, max_length=3)]
"""A place in space, in the frame of the robot's base, m."""


class SphereKind(SingleBarrier):
    """A barrier of spheres of the body, with bounds of its derivatives in closed form."""

    @abstractmethod
    def bounded(self, robot: Robot) -> BoundedFunction:
        """Return h and the bounds of its derivatives."""

    def h(self, robot: Robot) -> ca.SX:
        """Return h of the spheres that are named."""
        return self.bounded(robot).h

    def derivative_bounds(self, robot: Robot) -> DerivativeBounds | None:
        """Return the bounds that belong to h."""
        return self.bounded(robot).bounds


class EachSphereBarrier(SphereKind):
    """A barrier of each sphere, or of those that are named.

    Attributes:
        spheres: Names of the spheres that it holds for; every one by default.
    """

    spheres: Annotated[tuple[Name, ...], Field(max_length=64)] = ()

    def split(self, model: RobotModel) -> Iterator[Self]:
        """Yield the barrier for every sphere that it holds for.

        Raises:
            ValueError: The model has no such sphere.
        """
        for name in _known(self.name, self.spheres or model.spheres, model):
            yield self.model_copy(update={"name": f"{self.name}: {name}", "spheres": (name,)})


class BallBarrier(EachSphereBarrier):
    """A ball to keep out of, h = ‖c − centre‖² − (r + radius)², m², of a sphere with centre c and radius r.

    Attributes:
        centre: Centre of the ball, m.
        radius: Its radius, m.
    """

    h_unit: ClassVar[str] = "m²"

    kind: Literal["ball-keep-out"]
    centre: Spot
    radius: Positive

    def bounded(self, robot: Robot) -> BoundedFunction:
        """Return h of the one sphere that is named."""
        return ball_keep_out(sphere_of(robot, self.spheres[0]), centre=self.centre, radius=self.radius)

    def distance(self, robot: Robot) -> ca.SX:
        """Return the distance between sphere and ball."""
        sphere = sphere_of(robot, self.spheres[0])
        return ca.norm_2(sphere.centre - ca.DM(self.centre)) - sphere.radius_m - self.radius


class LevelBarrier(EachSphereBarrier):
    """A level to stay above, such as a table: h = c_z − r − height, m.

    Attributes:
        height_m: Height of the level, m.
    """

    h_unit: ClassVar[str] = "m"

    kind: Literal["level-keep-above"]
    height_m: Finite

    def bounded(self, robot: Robot) -> BoundedFunction:
        """Return h of the one sphere that is named."""
        return above_level(sphere_of(robot, self.spheres[0]), height=self.height_m)

    def distance(self, robot: Robot) -> ca.SX:
        """Return the distance between sphere and level, which h is."""
        return self.h(robot)


class SpheresApartBarrier(SphereKind):
    """Spheres of one robot that keep apart, h = ‖c₁ − c₂‖² − (r₁ + r₂)², m².

    Attributes:
        pairs: Names of the two spheres of each pair.
    """

    h_unit: ClassVar[str] = "m²"

    kind: Literal["spheres-apart"]
    pairs: Annotated[tuple[tuple[Name, Name], ...], Field(min_length=1, max_length=64)]

    @model_validator(mode="after")
    def _are_two(self) -> Self:
        if any(first == second for first, second in self.pairs):
            raise ValueError(f"pairs: got {self.pairs}, allowed two spheres in each")
        return self

    def split(self, model: RobotModel) -> Iterator[Self]:
        """Yield the barrier for every pair.

        Raises:
            ValueError: The model has no such sphere.
        """
        for pair in self.pairs:
            first, second = _known(self.name, pair, model)
            yield self.model_copy(update={"name": f"{self.name}: {first}, {second}", "pairs": (pair,)})

    def bounded(self, robot: Robot) -> BoundedFunction:
        """Return h of the one pair."""
        return spheres_apart(*self._spheres(robot))

    def distance(self, robot: Robot) -> ca.SX:
        """Return the distance between the spheres."""
        first, second = self._spheres(robot)
        return ca.norm_2(first.centre - second.centre) - first.radius_m - second.radius_m

    def _spheres(self, robot: Robot) -> tuple[BodySphere, BodySphere]:
        first, second = self.pairs[0]
        return sphere_of(robot, first), sphere_of(robot, second)


def sphere_of(robot: Robot, name: str) -> BodySphere:
    """Return a robot's sphere by its name.

    Raises:
        DesignError: It has none of that name.
    """
    found = {sphere.name: sphere for sphere in robot.spheres}
    if name not in found:
        allowed = ", ".join(found) or "none: the robot has no spheres"
        raise DesignError(f"sphere {name!r}", "none of the robot", allowed + suggestion(name, found))
    return found[name]


def _known(barrier: str, names: tuple[str, ...], model: RobotModel) -> tuple[str, ...]:
    unknown = [name for name in names if name not in model.spheres]
    if unknown or not names:
        allowed = ", ".join(model.spheres) or f"with a robot that has spheres, which {model.name!r} has not"
        got = f"sphere {unknown[0]!r} of barrier {barrier!r}" if unknown else f"barrier {barrier!r}"
        near = suggestion(unknown[0], model.spheres) if unknown else ""
        raise ValueError(f"filter.barriers: got {got}, allowed {allowed}{near}")
    return names
