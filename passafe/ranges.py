"""Checks of single numbers of a design."""

from math import inf, isfinite

from passafe.errors import DesignError


def require_positive(part: str, value: float, unit: str = "") -> None:
    """Refuse a number that is not positive and finite; the message states the unit, if there is one.

    Raises:
        DesignError: It is not.
    """
    if not 0 < value < inf:
        raise DesignError(part, value, f"a positive finite number{unit and ', '}{unit}")


def require_not_negative(part: str, value: float, unit: str) -> None:
    """Refuse a number that is negative or not finite.

    Raises:
        DesignError: It is not.
    """
    if not 0 <= value < inf:
        raise DesignError(part, value, f"zero or a positive finite number, {unit}")


def require_finite(part: str, value: float, unit: str) -> None:
    """Refuse a number that is not finite.

    Raises:
        DesignError: It is not.
    """
    if not isfinite(value):
        raise DesignError(part, value, f"a finite number, {unit}")
