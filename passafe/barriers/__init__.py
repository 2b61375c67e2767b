"""Barrier functions of common safe sets, one shape a file.

A shape is an expression of a position, a velocity or any other column of a plant's state; h ≥ 0 is the safe set.
Any of them moves when it is given a position from which a displacement has been taken::

    moving = disk_keep_out(robot.position - circular_motion(system.t, radius=0.5, frequency_hz=0.2), centre=…, radius=…)
"""

from passafe.barriers.box import box
from passafe.barriers.disk import disk_keep_in, disk_keep_out
from passafe.barriers.ellipse import ellipse_keep_in, ellipse_keep_out
from passafe.barriers.half_plane import half_plane
from passafe.barriers.motion import circular_motion, oscillating_motion, uniform_motion
from passafe.barriers.separation import separation
from passafe.barriers.speed_limit import speed_limit

__all__ = [
    "box",
    "circular_motion",
    "disk_keep_in",
    "disk_keep_out",
    "ellipse_keep_in",
    "ellipse_keep_out",
    "half_plane",
    "oscillating_motion",
    "separation",
    "speed_limit",
    "uniform_motion",
]
