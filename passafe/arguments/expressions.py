"""Expressions as callers write them: SX, numbers, or a sequence of both, as one column; else one typed error."""

from collections.abc import Sequence
from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.arguments.numbers import FOREIGN_ERRORS, described, is_one_number, numbers
from passafe.errors import DesignError, ShapeError

EXPRESSION: Final = "a casadi.SX expression, numbers, or a sequence of them"
ONLY_SX: Final = (
    "a casadi.SX expression: build it from casadi.SX.sym, MX cannot be taken apart into scalars;"
    " write a look-up table as a formula through its points"
)

DEEPEST: Final = 4
"""Sequences within one another that are unpacked, at most."""


def as_column(part: str, value: object, nested: int = 0) -> ca.SX:
    """Return something that stands for an expression as one; an SX expression is returned as it is.

    Args:
        part: What it is, for the message.
        value: An expression, a number, a vector of numbers, or a sequence of scalars of either kind, which makes a
            column.
        nested: In how many sequences it is.

    Raises:
        DesignError: It is none of these; MX is named as such.
    """
    if isinstance(value, ca.SX):
        return value
    if nested > DEEPEST:
        raise DesignError(part, "sequences within sequences without end", EXPRESSION)
    if isinstance(value, ca.MX):
        raise DesignError(part, described(value), ONLY_SX)
    if isinstance(value, ca.DM):
        return ca.SX(value)
    if is_one_number(value):
        return ca.SX(numbers(part, value, EXPRESSION)[0])
    if isinstance(value, np.ndarray) and value.dtype != object:
        return ca.SX(ca.DM(numbers(part, value, EXPRESSION)))
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes):
        return ca.vertcat(ca.SX(0, 1), *(as_column(part, element, nested + 1) for element in _elements(part, value)))
    try:
        return ca.SX(ca.DM(numbers(part, value, EXPRESSION)))
    except ShapeError as error:
        raise DesignError(part, error.got, EXPRESSION) from error


def _elements(part: str, value: Sequence[object] | NDArray[np.object_]) -> list[object]:
    try:
        return list(value.ravel()) if isinstance(value, np.ndarray) else [value[i] for i in range(len(value))]
    except FOREIGN_ERRORS as error:
        raise DesignError(part, described(value), EXPRESSION) from error
