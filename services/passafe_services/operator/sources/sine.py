"""Sinusoidal command on each axis."""

from math import cos, sin, tau
from typing import ClassVar

from msgspec import Struct
from passafe_protocol.messages import Vector

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock


class Sine(Struct, frozen=True, kw_only=True, gc=False):
    """u_h = offset + amplitude·sin(ωt + phase), u̇_h = amplitude·ω·cos(ωt + phase), ω = 2π·frequency.

    Attributes:
        amplitude: Amplitude of each axis, units of u.
        offset: Mean of each axis, units of u.
        phase_rad: Phase of each axis at t = 0, rad.
        frequency_hz: Frequency of all axes, Hz.
    """

    amplitude: Vector
    offset: Vector
    phase_rad: Vector
    frequency_hz: float
    device: ClassVar[str] = "sine"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        omega = tau * self.frequency_hz
        angles = [omega * t_s + phase for phase in self.phase_rad]
        u_h = [o + a * sin(x) for o, a, x in zip(self.offset, self.amplitude, angles, strict=True)]
        rate = [a * omega * cos(x) for a, x in zip(self.amplitude, angles, strict=True)]
        return Command(tuple(u_h), tuple(rate), True)
