"""From a barrier in a scenario file to its h as an expression of the robot's state and of plant time."""

import casadi as ca

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe.shapes import (
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
from services.scenarios.schema import (
    ApartBarrier,
    BarrierConfig,
    CoordinateBarrier,
    DiskBarrier,
    HalfPlaneBarrier,
    SpeedBarrier,
    Swing,
    Travel,
)

POINT: int = 2
"""Coordinates of one robot's position in the plane."""


def barrier_function(config: BarrierConfig, robot: Robot) -> ca.SX:
    """Return h of one barrier.

    Raises:
        DesignError: A vector of the wrong length, or a barrier that the robot's model cannot have.
    """
    if isinstance(config, SpeedBarrier):
        return speed_limit(robot.velocity, limit=config.limit)
    if isinstance(config, CoordinateBarrier):
        return _limit(config, robot)
    position = robot.position
    if isinstance(config, ApartBarrier):
        if position.numel() != 2 * POINT:
            raise DesignError(f"barrier {config.name!r}", "a model with one robot", "keep-apart with model two-points")
        return separation(position[:POINT], position[POINT:], distance=config.distance)
    if isinstance(config, HalfPlaneBarrier):
        return half_plane(position, normal=config.normal, offset=config.offset)
    seen = position - _displacement(config.motion, robot.system.t)
    if isinstance(config, DiskBarrier):
        disk = disk_keep_out if config.kind == "disk-keep-out" else disk_keep_in
        return disk(seen, centre=config.centre, radius=config.radius)
    ellipse = ellipse_keep_out if config.kind == "ellipse-keep-out" else ellipse_keep_in
    return ellipse(seen, centre=config.centre, semi_axes=config.semi_axes, rotation_rad=config.rotation_rad)


def _displacement(motion: Travel | Swing | None, t: ca.SX) -> ca.SX:
    if isinstance(motion, Travel):
        return uniform_motion(t, velocity=motion.velocity)
    if isinstance(motion, Swing):
        return oscillating_motion(
            t, amplitude=motion.amplitude, frequency_hz=motion.frequency_hz, phase_rad=motion.phase_rad
        )
    return ca.SX(0)


def _limit(config: CoordinateBarrier, robot: Robot) -> ca.SX:
    if config.index >= robot.system.n:
        raise DesignError(f"barrier {config.name!r} index", config.index, f"0 to {robot.system.n - 1}, a state's")
    sign = 1.0 if config.kind == "lower-limit" else -1.0
    return half_plane(robot.system.x[config.index], normal=(sign,), offset=sign * config.limit)
