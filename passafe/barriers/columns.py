"""Vectors of a shape as columns of finite numbers."""

from collections.abc import Sequence
from math import isfinite

import casadi as ca

from passafe.arguments.expressions import EXPRESSION, ONLY_SX
from passafe.arguments.numbers import described, numbers
from passafe.errors import DesignError, ShapeError


def column_like(part: str, vector: Sequence[float], coordinates: ca.SX) -> ca.DM:
    """Return a vector as a column, one finite number for each coordinate.

    Args:
        part: What it is, for messages.
        vector: k numbers.
        coordinates: Column that it goes with, shape (k, 1).

    Raises:
        ShapeError: Another number of numbers, or coordinates that are no column.
        DesignError: One that is not finite.
    """
    require_column(f"coordinates of {part}", coordinates)
    given = numbers(part, vector)
    if len(given) != coordinates.numel():
        raise ShapeError(part, f"{len(given)} numbers", f"{coordinates.numel()}, one for each coordinate")
    return finite_column(part, given)


def finite_column(part: str, vector: Sequence[float]) -> ca.DM:
    """Return a vector as a column of finite numbers.

    Raises:
        ShapeError: It is empty.
        DesignError: A number that is not finite.
    """
    given = numbers(part, vector)
    if not given:
        raise ShapeError(part, "no numbers", "at least one")
    if not all(map(isfinite, given)):
        raise DesignError(part, list(given), "finite numbers")
    return ca.DM(given)


def require_column(part: str, expression: ca.SX) -> None:
    """Refuse an expression that is not a column.

    Raises:
        DesignError: It is no SX expression.
        ShapeError: It is not a column.
    """
    if not isinstance(expression, ca.SX):
        raise DesignError(part, described(expression), ONLY_SX if isinstance(expression, ca.MX) else EXPRESSION)
    if not expression.is_column():
        raise ShapeError(part, f"shape {expression.shape}", "a column")
