"""Motions of barriers: displacements that the filter knows as functions of plant time."""

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Annotated, ClassVar, Literal, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from passafe.barriers.motion import circular_motion, oscillating_motion, uniform_motion
from passafe_services.scenarios.fields import Config, Finite, Place, Positive

FloatArray: TypeAlias = NDArray[np.float64]


class MotionKind(Config, ABC):
    """A displacement d(t) from where the scenario file places a barrier.

    Attributes:
        kind: Kind of motion.
        returns: Whether the barrier comes back again and again, so that a picture can hold all of its way.
    """

    kind: str
    returns: ClassVar[bool] = True

    @abstractmethod
    def displacement(self, t: ca.SX) -> ca.SX:
        """Return d(t), shape (2, 1), m, as an expression of plant time, s."""

    def displacements_m(self, t_s: FloatArray) -> FloatArray:
        """Return d at N plant times, s, shape (2, N), m, evaluated from ``displacement``."""
        return np.asarray(_compiled(self)(t_s.reshape(1, -1)).full(), dtype=np.float64)


class Travel(MotionKind):
    """Steady motion: d = velocity·t.

    Attributes:
        velocity_m_per_s: Velocity, m/s.
    """

    kind: Literal["travel"]
    velocity_m_per_s: Place

    returns: ClassVar[bool] = False

    def displacement(self, t: ca.SX) -> ca.SX:
        """Return velocity·t."""
        return uniform_motion(t, velocity=self.velocity_m_per_s)


class Swing(MotionKind):
    """Oscillation on a line: d = amplitude·sin(2π f t + phase).

    Attributes:
        amplitude_m: Largest displacement, m.
        frequency_hz: f, Hz.
        phase_rad: Phase at plant time 0, rad.
    """

    kind: Literal["swing"]
    amplitude_m: Place
    frequency_hz: Annotated[float, Field(gt=0, le=10)]
    phase_rad: Finite = 0.0

    def displacement(self, t: ca.SX) -> ca.SX:
        """Return amplitude·sin(2π f t + phase)."""
        return oscillating_motion(
            t, amplitude=self.amplitude_m, frequency_hz=self.frequency_hz, phase_rad=self.phase_rad
        )


class Circle(MotionKind):
    """Counter-clockwise motion on a circle: d = radius·(cos, sin)(2π f t + phase).

    Attributes:
        radius_m: Radius of the circle, m.
        frequency_hz: f, Hz.
        phase_rad: Phase at plant time 0, rad.
    """

    kind: Literal["circle"]
    radius_m: Positive
    frequency_hz: Annotated[float, Field(gt=0, le=10)]
    phase_rad: Finite = 0.0

    def displacement(self, t: ca.SX) -> ca.SX:
        """Return radius·(cos, sin)(2π f t + phase)."""
        return circular_motion(t, radius=self.radius_m, frequency_hz=self.frequency_hz, phase_rad=self.phase_rad)


Motion = Annotated[Travel | Swing | Circle, Field(discriminator="kind")]


@lru_cache(maxsize=256)
def _compiled(motion: MotionKind) -> ca.Function:
    t = ca.SX.sym("t")
    return ca.Function("displacement", [t], [ca.densify(motion.displacement(t))])
