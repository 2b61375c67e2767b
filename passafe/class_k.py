"""Extended class-K functions γ: continuous, strictly increasing, γ(0) = 0 (Ames et al. 2019, Definition 2)."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import casadi as ca

from passafe.arguments.numbers import described, is_one_number, members, one_number
from passafe.arguments.ranges import require_positive
from passafe.errors import DesignError


@dataclass(frozen=True, kw_only=True, slots=True)
class ClassK(ABC):
    """An extended class-K function with a positive gain.

    Attributes:
        gain: Slope or coefficient; 1/s where γ acts on a value and its derivative.
    """

    gain: float

    def __post_init__(self) -> None:
        """Refuse gains for which γ would not be strictly increasing."""
        require_positive("class-K function gain", self.gain)
        object.__setattr__(self, "gain", one_number("class-K function gain", self.gain))

    @abstractmethod
    def __call__(self, s: ca.SX) -> ca.SX:
        """Return γ(s) as an expression, same shape as ``s``."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Linear(ClassK):
    """γ(s) = gain·s."""

    def __call__(self, s: ca.SX) -> ca.SX:
        """Return gain·s."""
        return self.gain * s


@dataclass(frozen=True, kw_only=True, slots=True)
class Cubic(ClassK):
    """γ(s) = gain·s³: hardly anything near the boundary, much far from it."""

    def __call__(self, s: ca.SX) -> ca.SX:
        """Return gain·s³."""
        return self.gain * s * s * s


@dataclass(frozen=True, kw_only=True, slots=True)
class Piecewise(ClassK):
    """γ(s) = gain·s for s > 0 and gain_below·s otherwise: back to the set faster than towards its boundary.

    Attributes:
        gain_below: Slope for s ≤ 0.
    """

    gain_below: float

    def __post_init__(self) -> None:
        """Refuse gains for which γ would not be strictly increasing."""
        require_positive("class-K function gain", self.gain)
        require_positive("class-K function gain_below", self.gain_below)
        for name in ("gain", "gain_below"):
            object.__setattr__(self, name, one_number(f"class-K function {name}", getattr(self, name)))

    def __call__(self, s: ca.SX) -> ca.SX:
        """Return gain·s where s > 0, gain_below·s elsewhere."""
        return ca.if_else(s > 0, self.gain * s, self.gain_below * s)


def class_k_function(part: str, given: object) -> ClassK:
    """Return a class-K function, given as such or as the gain of a linear one.

    Raises:
        DesignError: It is neither.
    """
    if isinstance(given, ClassK):
        return given
    if is_one_number(given):
        return Linear(gain=one_number(part, given))
    raise DesignError(part, described(given), "class-K functions, or gains of linear ones")


def class_k_functions(part: str, given: object) -> tuple[ClassK, ...]:
    """Return a sequence of class-K functions, each given as such or as the gain of a linear one.

    Raises:
        DesignError: It is no sequence, or holds something else.
    """
    found = members(given)
    if found is None:
        raise DesignError(part, described(given), "a sequence of class-K functions, or of gains of linear ones")
    return tuple(class_k_function(part, each) for each in found)
