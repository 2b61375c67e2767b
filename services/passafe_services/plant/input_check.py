"""Validation of inputs at the plant: shape, limits and plausible times."""

from math import hypot, inf
from typing import Final

from passafe_protocol.messages import Header, PlantInput, Vector

from passafe.limits import Limits

ROUNDING: Final = 1e-12
"""Relative tolerance for an input that was scaled to the limit of its norm."""

FAR_NS: Final = 2**61
"""73 years: beyond every clock."""


class InputCheck:
    """Checks whether the plant may apply an input; the rate of change of u is not checked."""

    def __init__(self, limits: Limits) -> None:
        """Keep the limits.

        Args:
            limits: Limits of magnitude and norm; m axes.
        """
        self._m, self._bounds, self._least_bound = len(limits.magnitude), limits.magnitude, min(limits.magnitude)
        self._norm = inf if limits.norm is None else limits.norm * (1 + ROUNDING)

    def is_valid(self, header: Header, plant_input: PlantInput) -> bool:
        """Check whether the input of a message is applicable and its other numbers are plausible.

        The plant reports some of these numbers, so they must be valid in its own message.
        """
        if not self.is_applicable(plant_input.u):
            return False
        repeated, rest = divmod(len(plant_input.previous_u), self._m)
        is_timely = 0 <= plant_input.effective_plant_ns <= FAR_NS and -FAR_NS <= header.scheduled_ns <= FAR_NS
        return is_timely and not rest and repeated <= plant_input.tick

    def is_applicable(self, u: Vector) -> bool:
        """Check whether an input has the plant's shape and lies within the limits; a NaN does not."""
        if len(u) != self._m:
            return False
        least = self._least_bound
        for value in u:
            if not -least <= value <= least:
                return all(-bound <= value <= bound for value, bound in zip(u, self._bounds, strict=True)) and (
                    hypot(*u) <= self._norm
                )
        return self._norm == inf or hypot(*u) <= self._norm
