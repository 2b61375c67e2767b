"""Every shipped shape in the suite of ``boundary_suite``."""

from math import cos, pi, sin
from typing import ClassVar

import casadi as ca
import numpy as np
from boundary_suite import BarrierSuite, OnBoundary, pytest_generate_tests
from finite_differences import Array
from shipped_robots import IN_THE_PLANE

from passafe.barriers import (
    box,
    circular_motion,
    disk_keep_in,
    disk_keep_out,
    ellipse_keep_in,
    ellipse_keep_out,
    half_plane,
    oscillating_motion,
    separation,
    speed_limit,
    uniform_motion,
)
from passafe.models.robot import Robot

__all__ = ["pytest_generate_tests"]

CENTRE = np.array([0.4, -0.3])
AXES = np.array([1.5, 0.6])
TURN = 0.7
NORMAL = np.array([3.0, -4.0])


def unit(angle: float) -> Array:
    return np.array([cos(angle), sin(angle)])


def turned(vector: Array, angle: float) -> Array:
    return np.array([cos(angle) * vector[0] - sin(angle) * vector[1], sin(angle) * vector[0] + cos(angle) * vector[1]])


class Complement(BarrierSuite):
    """Keep in what the next class keeps out."""

    shape = "concave"

    def inside(self, place: Array, t: float) -> bool:
        return not super().inside(place, t)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        place, outward = super().on_boundary(rng, t)
        return OnBoundary(place, -outward)


class TestDiskKeepOut(BarrierSuite):
    robots = IN_THE_PLANE
    shape = "convex"
    radius: ClassVar[float] = 1.2

    def h(self, robot: Robot) -> ca.SX:
        return disk_keep_out(robot.position, centre=CENTRE.tolist(), radius=self.radius)

    def inside(self, place: Array, t: float) -> bool:
        return bool(np.hypot(*(place - CENTRE)) > self.radius)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        outward = unit(rng.uniform(0, 2 * pi))
        return OnBoundary(CENTRE + self.radius * outward, outward)


class TestDiskKeepIn(Complement, TestDiskKeepOut):
    radius = 3.0

    def h(self, robot: Robot) -> ca.SX:
        return disk_keep_in(robot.position, centre=CENTRE.tolist(), radius=self.radius)


class TestEllipseKeepOut(BarrierSuite):
    robots = IN_THE_PLANE
    shape = "convex"
    axes: ClassVar[Array] = AXES

    def h(self, robot: Robot) -> ca.SX:
        return ellipse_keep_out(robot.position, centre=CENTRE.tolist(), semi_axes=self.axes.tolist(), rotation_rad=TURN)

    def inside(self, place: Array, t: float) -> bool:
        # Distances to both foci add up to more than twice the longer semi-axis.
        focus = turned(np.array([np.sqrt(self.axes[0] ** 2 - self.axes[1] ** 2), 0.0]), TURN)
        return bool(np.hypot(*(place - CENTRE - focus)) + np.hypot(*(place - CENTRE + focus)) > 2 * self.axes[0])

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        angle = rng.uniform(0, 2 * pi)
        outward = turned(np.array([self.axes[1] * cos(angle), self.axes[0] * sin(angle)]), TURN)
        place = CENTRE + turned(self.axes * unit(angle), TURN)
        return OnBoundary(place, outward / np.hypot(*outward))


class TestEllipseKeepIn(Complement, TestEllipseKeepOut):
    axes = np.array([4.0, 2.5])

    def h(self, robot: Robot) -> ca.SX:
        return ellipse_keep_in(robot.position, centre=CENTRE.tolist(), semi_axes=self.axes.tolist(), rotation_rad=TURN)


class TestHalfPlane(BarrierSuite):
    robots = IN_THE_PLANE
    shape = "affine"

    def h(self, robot: Robot) -> ca.SX:
        return half_plane(robot.position, normal=NORMAL.tolist(), offset=2.0)

    def inside(self, place: Array, t: float) -> bool:
        # The line 3p₁ − 4p₂ = 2 runs through (2, 1) and (−2, −2); safe is to the right of that way along it.
        (x1, y1), (x2, y2) = (-2.0, -2.0), (2.0, 1.0)
        return bool((x2 - x1) * (place[1] - y1) - (y2 - y1) * (place[0] - x1) < 0)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        return OnBoundary(np.array([2.0, 1.0]) + rng.uniform(-3, 3) * np.array([0.8, 0.6]), np.array([0.6, -0.8]))


class BoxSide(BarrierSuite):
    """One side of a box that is as wide as it is high; ``axis`` and ``top`` say which."""

    shape = "affine"
    low: ClassVar[float] = -1.5
    high: ClassVar[float] = 2.0
    axis: ClassVar[int]
    top: ClassVar[bool]

    def h(self, robot: Robot) -> ca.SX:
        coordinates = robot.position if self.of == "position" else robot.velocity
        k = coordinates.numel()
        return box(coordinates, low=[self.low] * k, high=[self.high] * k)[2 * self.axis + self.top]

    def inside(self, place: Array, t: float) -> bool:
        return bool(place[self.axis] < self.high if self.top else place[self.axis] > self.low)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        place = rng.uniform(-2, 2, self.coordinates)
        place[self.axis] = self.high if self.top else self.low
        return OnBoundary(place, (-1.0 if self.top else 1.0) * np.eye(self.coordinates)[self.axis])

    coordinates: ClassVar[int] = 2


class TestRoomLowerWall(BoxSide):
    robots = IN_THE_PLANE
    axis, top = 0, False


class TestRoomUpperWall(BoxSide):
    robots = IN_THE_PLANE
    axis, top = 1, True


class TestJointLimit(BoxSide):
    robots = ("joint chain",)
    coordinates = 3
    axis, top = 2, True


class TestVelocityLimit(BoxSide):
    of = "velocity"
    robots = IN_THE_PLANE
    axis, top = 1, False


class TestJointSpeedLimit(BoxSide):
    of = "velocity"
    robots = ("joint chain",)
    coordinates = 3
    axis, top = 0, True


class TestSpeedLimit(BarrierSuite):
    of = "velocity"
    robots = IN_THE_PLANE
    shape = "concave"

    def h(self, robot: Robot) -> ca.SX:
        return speed_limit(robot.velocity, limit=1.5)

    def inside(self, place: Array, t: float) -> bool:
        return bool(np.hypot(*place) < 1.5)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        direction = unit(rng.uniform(0, 2 * pi))
        return OnBoundary(1.5 * direction, -direction)


class TestSeparation(BarrierSuite):
    robots = ("two points",)
    shape = "convex"

    def h(self, robot: Robot) -> ca.SX:
        return separation(robot.position[:2], robot.position[2:], distance=0.8)

    def inside(self, place: Array, t: float) -> bool:
        return bool(np.hypot(*(place[:2] - place[2:])) > 0.8)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        one, direction = rng.uniform(-2, 2, 2), unit(rng.uniform(0, 2 * pi))
        return OnBoundary(
            np.concatenate([one, one + 0.8 * direction]), np.concatenate([-direction, direction]) / 2**0.5
        )


class MovingDisk(BarrierSuite):
    """A disk whose centre is somewhere else at every time."""

    robots = IN_THE_PLANE
    shape = "convex"
    moves = True

    def displacement(self, t: ca.SX) -> ca.SX:
        raise NotImplementedError

    def centre(self, t: float) -> Array:
        raise NotImplementedError

    def h(self, robot: Robot) -> ca.SX:
        seen = robot.position - self.displacement(robot.system.t)
        return disk_keep_out(seen, centre=CENTRE.tolist(), radius=0.9)

    def inside(self, place: Array, t: float) -> bool:
        return bool(np.hypot(*(place - self.centre(t))) > 0.9)

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        outward = unit(rng.uniform(0, 2 * pi))
        return OnBoundary(self.centre(t) + 0.9 * outward, outward)


class TestUniformMotion(MovingDisk):
    def displacement(self, t: ca.SX) -> ca.SX:
        return uniform_motion(t, velocity=(0.5, -0.25))

    def centre(self, t: float) -> Array:
        return np.array([0.4 + t / 2, -0.3 - t / 4])


class TestOscillatingMotion(MovingDisk):
    def displacement(self, t: ca.SX) -> ca.SX:
        return oscillating_motion(t, amplitude=(1.0, 2.0), frequency_hz=0.25, phase_rad=0.5)

    def centre(self, t: float) -> Array:
        return CENTRE + np.array([1.0, 2.0]) * sin(pi / 2 * t + 0.5)


class TestCircularMotion(MovingDisk):
    def displacement(self, t: ca.SX) -> ca.SX:
        return circular_motion(t, radius=1.5, frequency_hz=0.2, phase_rad=-1.0)

    def centre(self, t: float) -> Array:
        return CENTRE + 1.5 * unit(0.4 * pi * t - 1.0)


class TestMovingWall(BarrierSuite):
    robots = IN_THE_PLANE
    shape = "affine"
    moves = True

    def h(self, robot: Robot) -> ca.SX:
        seen = robot.position - oscillating_motion(robot.system.t, amplitude=(1.0, 0.0), frequency_hz=0.5)
        return half_plane(seen, normal=(1.0, 0.0), offset=-2.0)

    def inside(self, place: Array, t: float) -> bool:
        return bool(place[0] > -2.0 + sin(pi * t))

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        return OnBoundary(np.array([-2.0 + sin(pi * t), rng.uniform(-3, 3)]), np.array([1.0, 0.0]))
