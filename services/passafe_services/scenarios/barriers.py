"""From a barrier of a scenario to its h as an expression of the robot's state and of plant time."""

import casadi as ca

from passafe.barriers import (
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
from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_schema import (
    ApartBarrier,
    DiskBarrier,
    EllipseBarrier,
    Motion,
    SpeedBarrier,
    Swing,
    Travel,
)
from passafe_services.scenarios.single_barriers import CoordinateLimit, PlaceBarrier, SingleBarrier


def barrier_function(barrier: SingleBarrier, robot: Robot) -> ca.SX:
    """Return h of one barrier.

    Raises:
        DesignError: A limit of a coordinate that the robot does not have.
    """
    if isinstance(barrier, CoordinateLimit):
        return _limit(barrier, robot)
    if isinstance(barrier, ApartBarrier):
        return separation(_of(robot.position, 1), _of(robot.position, 2), distance=barrier.distance_m)
    if isinstance(barrier, SpeedBarrier):
        return speed_limit(_of(robot.velocity, barrier.point), limit=barrier.limit_m_per_s)
    return _place(barrier, robot)


def _place(barrier: PlaceBarrier, robot: Robot) -> ca.SX:
    """Return h of a set of places, seen from where the set has moved to."""
    seen = _of(robot.position, barrier.point)
    if barrier.motion is not None:
        seen = seen - _displacement(barrier.motion, robot.system.t)
    if isinstance(barrier, DiskBarrier):
        disk = disk_keep_out if barrier.kind == "disk-keep-out" else disk_keep_in
        return disk(seen, centre=barrier.centre, radius=barrier.radius)
    if isinstance(barrier, EllipseBarrier):
        ellipse = ellipse_keep_out if barrier.kind == "ellipse-keep-out" else ellipse_keep_in
        return ellipse(seen, centre=barrier.centre, semi_axes=barrier.semi_axes_m, rotation_rad=barrier.rotation_rad)
    return half_plane(seen, normal=barrier.normal, offset=barrier.offset)


def _of(coordinates: ca.SX, point: int | None) -> ca.SX:
    """Return those two coordinates that belong to a point, counted from 1."""
    first = 2 * ((point or 1) - 1)
    return coordinates[first : first + 2]


def _displacement(motion: Motion, t: ca.SX) -> ca.SX:
    if isinstance(motion, Travel):
        return uniform_motion(t, velocity=motion.velocity_m_per_s)
    if isinstance(motion, Swing):
        return oscillating_motion(
            t, amplitude=motion.amplitude_m, frequency_hz=motion.frequency_hz, phase_rad=motion.phase_rad
        )
    return circular_motion(t, radius=motion.radius_m, frequency_hz=motion.frequency_hz, phase_rad=motion.phase_rad)


def _limit(barrier: CoordinateLimit, robot: Robot) -> ca.SX:
    coordinates = robot.position if barrier.of == "position" else robot.velocity
    if barrier.index >= coordinates.numel():
        raise DesignError(f"barrier {barrier.name!r}", f"coordinate {barrier.index + 1}", f"1 to {coordinates.numel()}")
    sign = -1.0 if barrier.upper else 1.0
    return half_plane(coordinates[barrier.index], normal=(sign,), offset=sign * barrier.bound)
