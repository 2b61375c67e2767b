"""Validation of inputs at the plant: shape, limits and plausible times."""

from math import hypot
from typing import Final

from passafe_protocol.messages import Header, PlantInput, Vector

from passafe.limits import Limits

ROUNDING: Final = 2e-12
"""Relative tolerance for an input that was led to the limit of a norm or a half-space."""

FAR_NS: Final = 2**61
"""73 years: beyond every clock."""


class InputCheck:
    """Checks whether the plant may apply an input; the rate of change of u is not checked."""

    def __init__(self, limits: Limits) -> None:
        """Keep the limits.

        Args:
            limits: The filter's; m axes.
        """
        self._m, self._limits = len(limits.low), limits
        self._axes = tuple(zip(limits.low, limits.high, strict=True))
        self._inside_all = min(min(-low, high) for low, high in self._axes)  # negative where zero is outside
        self._has_only_axes = limits.has_only_axes
        self._past_planes = ROUNDING * limits.reach

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
        inside = self._inside_all
        for value in u:
            if not -inside <= value <= inside:
                return all(low <= value <= high for value, (low, high) in zip(u, self._axes, strict=True)) and (
                    self._has_only_axes or self._keeps_shapes(u)
                )
        return self._has_only_axes or self._keeps_shapes(u)

    def _keeps_shapes(self, u: Vector) -> bool:
        for norm in self._limits.norms:
            if not hypot(*(u[axis] for axis in norm.axes)) <= norm.bound * (1 + ROUNDING):
                return False
        for plane in self._limits.half_spaces:
            if not sum(w * value for w, value in zip(plane.weights, u, strict=True)) <= plane.bound + self._past_planes:
                return False
        return True
