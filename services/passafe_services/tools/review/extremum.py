"""An extreme value and when it occurred."""

from typing import NamedTuple, Self

import numpy as np

from passafe_services.tools.review.plant_evaluator import FloatArray


class Extremum(NamedTuple):
    """Extreme value and the plant time, s, at which it occurred."""

    value: float
    at_s: float

    @classmethod
    def lowest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """Return the smallest of at least one value; a NaN counts as −∞."""
        known = np.where(np.isnan(values), -np.inf, values)
        where = int(np.argmin(known))
        return cls(float(known[where]), float(t_s[where]))

    @classmethod
    def highest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """Return the largest of at least one value; a NaN counts as +∞."""
        lowest = cls.lowest(-values, t_s)
        return cls(-lowest.value, lowest.at_s)
