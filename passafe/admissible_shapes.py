"""Shapes that limit several axes of the input at once: the norm of some of them, and a weighted sum."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from passafe.arguments.numbers import described, numbers, one_number
from passafe.arguments.ranges import LARGEST_INPUT, require_positive
from passafe.errors import DesignError
from passafe.numerics.fixed_order import length


@dataclass(frozen=True, kw_only=True, slots=True)
class NormBound:
    """The ball ‖(uᵢ)‖ ≤ bound over some axes i, as the force of a motor with two phases or of one robot of several.

    Attributes:
        axes: Their numbers, from 0; each once.
        bound: Positive, units of u.
    """

    axes: tuple[int, ...]
    bound: float

    def __post_init__(self) -> None:
        """Refuse what limits nothing."""
        require_positive("input norm bound", self.bound)
        if one_number("input norm bound", self.bound) > LARGEST_INPUT:
            raise DesignError("input norm bound", f"{self.bound:g}", f"at most {LARGEST_INPUT:g}, units of u")
        given = numbers("input norm axes", self.axes)
        axes = tuple(int(axis) for axis in given if isfinite(axis))
        if not axes or min(axes) < 0 or len(set(axes)) != len(axes) or axes != given:
            raise DesignError("input norm axes", described(self.axes), "numbers of axes from 0, each once")
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "bound", one_number("input norm bound", self.bound))


@dataclass(frozen=True, kw_only=True, slots=True)
class HalfSpace:
    """The inputs with weightsᵀu ≤ bound, as a common supply of several motors; several make a polytope A u ≤ b.

    Attributes:
        weights: One for each axis, not all zero; scaled to unit length here.
        bound: Finite, in the units of weightsᵀu; scaled likewise, and then in units of u.
    """

    weights: tuple[float, ...]
    bound: float

    def __post_init__(self) -> None:
        """Scale to unit length, and refuse what is no half-space."""
        weights, bound = numbers("input half-space weights", self.weights), one_number("input half-space", self.bound)
        size = length(np.array(weights))
        if not 0.0 < size < inf or not abs(bound) / size <= LARGEST_INPUT:
            got = f"weights {list(weights)}, bound {bound}"
            allowed = f"finite numbers, a weight that is not zero, a bound within ±{LARGEST_INPUT:g} times their length"
            raise DesignError("input half-space", got, allowed)
        object.__setattr__(self, "weights", tuple(weight / size for weight in weights))
        object.__setattr__(self, "bound", bound / size)
