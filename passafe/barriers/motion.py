"""Known motions: displacements as expressions of plant time.

A static shape moves with a displacement d(t) when it is given p − d(t) for its position p.
"""

from collections.abc import Sequence
from math import pi

import casadi as ca

from passafe.arguments.ranges import require_finite, require_positive
from passafe.barriers.columns import finite_column
from passafe.errors import ShapeError


def uniform_motion(t: ca.SX, *, velocity: Sequence[float]) -> ca.SX:
    """Return d(t) = velocity·t, shape (k, 1), m.

    Args:
        t: Plant time, the system's ``t``, s.
        velocity: k numbers, m/s.

    Raises:
        ShapeError: A t that is no scalar, or no velocity.
        DesignError: A number that is not finite.
    """
    _require_time(t)
    return finite_column("uniform motion velocity", velocity) * t


def oscillating_motion(t: ca.SX, *, amplitude: Sequence[float], frequency_hz: float, phase_rad: float = 0.0) -> ca.SX:
    """Return d(t) = amplitude·sin(2π f t + phase): back and forth on a line, shape (k, 1), m.

    Args:
        t: Plant time, the system's ``t``, s.
        amplitude: k numbers, m.
        frequency_hz: f, positive, Hz.
        phase_rad: rad.

    Raises:
        ShapeError: A t that is no scalar, or no amplitude.
        DesignError: Numbers that make no oscillation.
    """
    return finite_column("oscillating motion amplitude", amplitude) * ca.sin(_angle(t, frequency_hz, phase_rad))


def circular_motion(t: ca.SX, *, radius: float, frequency_hz: float, phase_rad: float = 0.0) -> ca.SX:
    """Return d(t) = radius·(cos, sin)(2π f t + phase): counter-clockwise in the plane, shape (2, 1), m.

    Args:
        t: Plant time, the system's ``t``, s.
        radius: Positive, m.
        frequency_hz: f, positive, Hz.
        phase_rad: rad.

    Raises:
        ShapeError: A t that is no scalar.
        DesignError: Numbers that make no circle.
    """
    require_positive("circular motion radius", radius, "m")
    angle = _angle(t, frequency_hz, phase_rad)
    return radius * ca.vertcat(ca.cos(angle), ca.sin(angle))


def _angle(t: ca.SX, frequency_hz: float, phase_rad: float) -> ca.SX:
    _require_time(t)
    require_positive("motion frequency_hz", frequency_hz, "Hz")
    require_finite("motion phase_rad", phase_rad, "rad")
    return 2 * pi * frequency_hz * t + phase_rad


def _require_time(t: ca.SX) -> None:
    if not t.is_scalar():
        raise ShapeError("motion t", f"shape {t.shape}", "a scalar")
