"""The exact model as the robot."""

from collections.abc import Sequence

from passafe_protocol.messages import Vector

from passafe.sampled_plant import SampledPlant
from passafe_services.drivers.plant_driver import Reading


class ModelDriver:
    """Integrates the model, one period at a time, under the input applied last.

    Attributes:
        has_own_clock: False: a simulation.
    """

    has_own_clock = False

    def __init__(self, plant: SampledPlant, *, x0: Sequence[float], period_ns: int) -> None:
        """Put the robot at rest at x0.

        Args:
            plant: Model of the robot, stepped with the period.
            x0: Initial state, n numbers.
            period_ns: Period of a step, ns.
        """
        self._plant = plant
        self._sample = plant.at(x0)
        self._period_ns = period_ns
        self._u: Vector = ()
        self._at_ns = 0

    def open(self) -> None:
        """Do nothing: a model is always ready."""

    def read(self, at_ns: int) -> Reading:
        """Return the state at ``at_ns``; x0 before the first input."""
        if self._u:
            while self._at_ns + self._period_ns <= at_ns:
                self._sample = self._plant.advance(self._sample.x, self._u)
                self._at_ns += self._period_ns
        sample = self._sample
        return Reading(sample.x, at_ns, sample)

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force."""
        self._u, self._at_ns = u, at_ns

    def close(self) -> None:
        """Do nothing: a model stops when it is asked no more."""
