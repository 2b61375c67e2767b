"""Checks of single numbers of a design."""

from math import inf, isfinite
from typing import Final

import numpy as np

from passafe.arguments.numbers import described, is_one_number, numbers
from passafe.errors import DesignError

LARGEST_INPUT: Final = 1e100
"""Largest limit of an input, units of u: squares of it are still numbers."""


def require_positive(part: str, value: float, unit: str = "") -> None:
    """Refuse a number that is not positive and finite; the message states the unit, if there is one.

    Raises:
        DesignError: It is not.
    """
    allowed = f"a positive finite number{unit and ', '}{unit}"
    if not 0 < _number(part, value, allowed) < inf:
        raise DesignError(part, value, allowed)


def require_not_negative(part: str, value: float, unit: str) -> None:
    """Refuse a number that is negative or not finite.

    Raises:
        DesignError: It is not.
    """
    allowed = f"zero or a positive finite number, {unit}"
    if not 0 <= _number(part, value, allowed) < inf:
        raise DesignError(part, value, allowed)


def require_finite(part: str, value: float, unit: str) -> None:
    """Refuse a number that is not finite.

    Raises:
        DesignError: It is not.
    """
    allowed = f"a finite number, {unit}"
    if not isfinite(_number(part, value, allowed)):
        raise DesignError(part, value, allowed)


def _number(part: str, value: object, allowed: str) -> float:
    """Return a number on its own as a float; an integer beyond the doubles is none, nor is a signalling NaN."""
    if not is_one_number(value):
        raise DesignError(part, described(value), allowed)
    return numbers(part, value, allowed)[0]


def yes_or_no(part: str, value: object) -> bool:
    """Return a truth value as ``bool``; a word such as "no", which would count as true, is refused.

    Raises:
        DesignError: It is none.
    """
    if not isinstance(value, bool | np.bool_):
        raise DesignError(part, described(value), "True or False")
    return bool(value)
