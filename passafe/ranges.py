"""What single numbers of a design may be."""

from math import inf, isfinite

from passafe.errors import DesignError


def require_positive(part: str, value: float, unit: str) -> None:
    """Refuse what is no positive finite number.

    Raises:
        DesignError: It is not.
    """
    if not 0 < value < inf:
        raise DesignError(part, value, f"a positive finite number, {unit}")


def require_not_negative(part: str, value: float, unit: str) -> None:
    """Refuse what is no finite number from zero on.

    Raises:
        DesignError: It is not.
    """
    if not 0 <= value < inf:
        raise DesignError(part, value, f"zero or a positive finite number, {unit}")


def require_finite(part: str, value: float, unit: str) -> None:
    """Refuse what is no finite number.

    Raises:
        DesignError: It is not.
    """
    if not isfinite(value):
        raise DesignError(part, value, f"a finite number, {unit}")
