"""How far a person who steers is from losing the robot: margins of the crossover model's loop."""

from dataclasses import dataclass
from math import atan, hypot, pi, sqrt


@dataclass(frozen=True, kw_only=True, slots=True)
class CrossoverLoop:
    """The open loop L(s) = ω_c e^{−τs} / (s (T s + 1)) of person and robot (McRuer & Jex 1967).

    τ is the reaction time and half a glance: what is seen is held until the next glance, which delays it by half of
    the time between the two on average. That holds while ω_c times a glance is well below 1.

    Attributes:
        crossover_rad_per_s: ω_c, gain of the person and the robot together.
        reaction_s: From the eye to the muscle's command, s.
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
        """Where |L| = 1, rad/s: ω²(T²ω² + 1) = ω_c². A little below ω_c, which the lag takes gain from."""
        # The positive root for ω², written so that it loses no digits as T → 0.
        product = 2 * self.neuromuscular_s * self.crossover_rad_per_s
        return self.crossover_rad_per_s * sqrt(2 / (1 + hypot(1, product)))

    @property
    def phase_margin_rad(self) -> float:
        """π/2 − τω − atan(Tω) where |L| = 1, rad; negative where the loop is unstable by itself."""
        omega = self.unit_gain_rad_per_s
        return pi / 2 - self.delay_s * omega - atan(self.neuromuscular_s * omega)

    @property
    def delay_margin_s(self) -> float:
        """Delay from anywhere else around the loop at which it begins to oscillate and grow, s.

        The phase margin by the frequency at which |L| = 1, the only one: |L| falls with ω, so that the loop is
        unstable for every delay above (Nyquist).
        """
        return self.phase_margin_rad / self.unit_gain_rad_per_s
