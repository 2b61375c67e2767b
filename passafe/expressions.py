"""Expressions as callers write them: SX, numbers, or a sequence of both, as one column; else one typed error."""

from collections.abc import Sequence
from typing import Final

import casadi as ca
import numpy as np

from passafe.arguments import described, is_one_number, numbers
from passafe.errors import DesignError

EXPRESSION: Final = "a casadi.SX expression, numbers, or a sequence of them"
ONLY_SX: Final = (
    "a casadi.SX expression: build it from casadi.SX.sym, MX cannot be taken apart into scalars;"
    " write a look-up table as a formula through its points"
)


def as_column(part: str, value: object) -> ca.SX:
    """Return something that stands for an expression as one; an SX expression is returned as it is.

    Args:
        part: What it is, for the message.
        value: An expression, a number, a vector of numbers, or a sequence of scalars of either kind, which makes a
            column.

    Raises:
        DesignError: It is none of these; MX is named as such.
    """
    if isinstance(value, ca.SX):
        return value
    if isinstance(value, ca.MX):
        raise DesignError(part, described(value), ONLY_SX)
    if isinstance(value, ca.DM):
        return ca.SX(value)
    if is_one_number(value):
        return ca.SX(numbers(part, value, EXPRESSION)[0])
    if isinstance(value, np.ndarray) and value.dtype != object:
        return ca.SX(ca.DM(numbers(part, value, EXPRESSION)))
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes):
        elements = list(value.ravel()) if isinstance(value, np.ndarray) else list(value)
        return ca.vertcat(ca.SX(0, 1), *(as_column(part, element) for element in elements))
    raise DesignError(part, described(value), EXPRESSION)
