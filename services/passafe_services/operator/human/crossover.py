"""Stability margins of a person who steers: the loop of the crossover model."""

from dataclasses import dataclass
from math import atan, hypot, pi, sqrt


@dataclass(frozen=True, kw_only=True, slots=True)
class CrossoverLoop:
    """Open loop L(s) = ω_c e^{−τs} / (s (T s + 1)) of person and robot (McRuer & Jex 1967).

    τ is the reaction time plus half the glance interval: an observation is held until the next glance, which delays it
    by half an interval on average. This holds while ω_c times the interval is well below 1.

    Attributes:
        crossover_rad_per_s: ω_c, gain of person and robot together.
        reaction_s: Delay from the eye to the muscle's command, s.
        neuromuscular_s: T, lag of the arm, s.
        glance_s: Time between two glances, s.
    """

    crossover_rad_per_s: float
    reaction_s: float
    neuromuscular_s: float
    glance_s: float

    @property
    def delay_s(self) -> float:
        """τ, s."""
        return self.reaction_s + self.glance_s / 2

    @property
    def effective_delay_s(self) -> float:
        """τ_e = τ + T, s: the one delay of the crossover model, in which the lag is counted as a delay."""
        return self.delay_s + self.neuromuscular_s

    @property
    def unit_gain_rad_per_s(self) -> float:
        """Crossover frequency with the lag, |L| = 1, rad/s: ω²(T²ω² + 1) = ω_c²; slightly below ω_c."""
        # The positive root for ω², in a form without cancellation as T → 0.
        product = 2 * self.neuromuscular_s * self.crossover_rad_per_s
        return self.crossover_rad_per_s * sqrt(2 / (1 + hypot(1, product)))

    @property
    def phase_margin_rad(self) -> float:
        """π/2 − τω − atan(Tω) at |L| = 1, rad; negative if the loop is unstable without further delay."""
        omega = self.unit_gain_rad_per_s
        return pi / 2 - self.delay_s * omega - atan(self.neuromuscular_s * omega)

    @property
    def delay_margin_s(self) -> float:
        """Additional loop delay above which the loop is unstable, s.

        The phase margin divided by the only frequency with |L| = 1: |L| decreases with ω, so the loop is unstable for
        every larger delay (Nyquist).
        """
        return self.phase_margin_rad / self.unit_gain_rad_per_s
