"""Numbers as callers have them: any sequence of numbers as a tuple of floats, anything else as one typed error.

Taken are lists, tuples, ranges, arrays of NumPy and of whatever converts to one, and CasADi's DM, with elements of any
real type; at most one axis may be longer than one, so that a column or a row counts as the vector that it holds.
"""

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from numbers import Real
from reprlib import Repr
from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.errors import ShapeError

NUMBERS: Final = "numbers: a sequence, NumPy array or casadi.DM with one axis"

FOREIGN_ERRORS: Final = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
"""Errors of the conversion of a caller's own object: a tensor with a gradient, a list in itself, a broken sequence."""

_SHORT: Final = Repr()
_SHORT.maxlevel = 2  # sequences within sequences

_REFUSED: Final = (str, bytes, bytearray, Mapping, set, frozenset, ca.SX, ca.MX)
_REAL_KINDS: Final = "biuf"


def numbers(field: str, value: object, allowed: str = NUMBERS) -> tuple[float, ...]:
    """Return the numbers of a vector, or of a number on its own, as floats.

    Args:
        field: What they are, for the message.
        value: The vector.
        allowed: What is allowed, for the message.

    Raises:
        ShapeError: It holds something that is no real number, or has two axes longer than one.
    """
    try:
        found = _floats(value)
    except FOREIGN_ERRORS as error:
        raise ShapeError(field, described(value), allowed) from error
    if found is None:
        raise ShapeError(field, described(value), allowed)
    return found


def one_number(field: str, value: object) -> float:
    """Return a number, or the only one of a sequence, as a float.

    Raises:
        ShapeError: It is no real number, or not one.
    """
    found = numbers(field, value, "one number")
    if len(found) != 1:
        raise ShapeError(field, described(value), "one number")
    return found[0]


def vectors(given: Mapping[str, object], sizes: Sequence[int]) -> list[tuple[float, ...]]:
    """Return the numbers of several vectors.

    Args:
        given: Vectors by their names.
        sizes: How many numbers each must have.

    Raises:
        ShapeError: One is no vector of numbers, or has another length.
    """
    found = [numbers(field, value) for field, value in given.items()]
    lengths = [len(each) for each in found]
    if lengths != list(sizes):
        raise ShapeError(", ".join(given), f"lengths {_listed(lengths)}", f"lengths {_listed(sizes)}")
    return found


def members(value: object) -> tuple[object, ...] | None:
    """Return what is in an iterable, in order; ``None`` for text and whatever cannot be gone through."""
    if isinstance(value, str | bytes | ca.SX | ca.MX | ca.DM) or not isinstance(value, Iterable):
        return None
    try:
        return tuple(value)
    except FOREIGN_ERRORS:
        return None


def is_one_number(value: object) -> bool:
    """Return whether something is a real number on its own, not a sequence of one."""
    return isinstance(value, Real | Decimal | np.bool_) or (isinstance(value, np.ndarray) and value.ndim == 0)


def described(value: object) -> str:
    """Return what something is, in a few words for a message."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of shape {value.shape}"
    if isinstance(value, ca.DM | ca.SX | ca.MX):
        return f"a casadi.{type(value).__name__} of shape {value.shape}"
    return "None" if value is None else f"{' '.join(_SHORT.repr(value).split())} ({type(value).__name__})"


def _floats(value: object) -> tuple[float, ...] | None:
    """Return the numbers of a vector, or ``None`` if it is none."""
    if isinstance(value, _REFUSED) or np.ma.is_masked(value):  # behind a mask are numbers, but not those that are meant
        return None
    if isinstance(value, Real | Decimal):
        return _all_of([_float(value)])
    if isinstance(value, ca.DM):
        return _of_array(value.full())
    if isinstance(value, Sequence):
        is_row = len(value) == 1 and not isinstance(value[0], Real)
        return _floats(value[0]) if is_row else _all_of([_float(element) for element in value])
    try:
        return _of_array(np.asarray(value))
    except (TypeError, ValueError):  # what it converts itself with has refused
        return None


def _all_of(found: Sequence[float | None]) -> tuple[float, ...] | None:
    present = tuple(number for number in found if number is not None)
    return present if len(present) == len(found) else None


def _of_array(array: NDArray[np.generic]) -> tuple[float, ...] | None:
    if sum(size != 1 for size in array.shape) > 1:
        return None
    if array.dtype == object:  # for example of integers that may be missing
        return _all_of([_float(element) for element in array.ravel()])
    if array.dtype.kind not in _REAL_KINDS:
        return None
    with np.errstate(over="ignore"):  # a long double beyond the doubles is infinite
        return tuple(array.astype(np.float64).ravel().tolist())


def _float(element: object) -> float | None:
    """Return an element of a sequence as a float; a vector of one number counts as that number."""
    if isinstance(element, Real | Decimal):
        try:
            return float(element)
        except (OverflowError, ValueError):  # an integer beyond the doubles; a signalling NaN
            return None
    found = _floats(element)
    return found[0] if found is not None and len(found) == 1 else None


def _listed(lengths: Sequence[int]) -> str:
    return ", ".join(map(str, lengths))
