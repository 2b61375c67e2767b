"""Limits as callers write them: one number for every axis or one for each, symmetric or for each side."""

from collections.abc import Sequence
from math import inf
from typing import TypeVar

from passafe.arguments.numbers import described, is_one_number, members, numbers
from passafe.arguments.ranges import LARGEST_INPUT, require_positive
from passafe.errors import DesignError, ShapeError

PerAxis = float | Sequence[float]
Kind = TypeVar("Kind")


def interval_of(
    m: int, magnitude: PerAxis | None, low: PerAxis | None, high: PerAxis | None
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the least and the largest input of each axis; ``low`` and ``high`` are in the place of the magnitude.

    Raises:
        ShapeError: Another number of axes.
        DesignError: Numbers between which there is nothing.
    """
    bound = _each_axis("input_bound", magnitude, m) if low is None or high is None else ()
    for one in bound:
        require_positive("input_bound", one)
    least = tuple(-one for one in bound) if low is None else _each_axis("input_low", low, m)
    most = bound if high is None else _each_axis("input_high", high, m)
    if not all(-LARGEST_INPUT <= lower < upper <= LARGEST_INPUT for lower, upper in zip(least, most, strict=True)):
        allowed = f"within ±{LARGEST_INPUT:g}, every high above its low"
        raise DesignError("input_low, input_high", f"{list(least)}, {list(most)}", allowed)
    return least, most


def rates_of(
    m: int, rate: PerAxis | None, low: PerAxis | None, high: PerAxis | None
) -> tuple[tuple[float, ...] | None, tuple[float, ...] | None]:
    """Return the fastest fall and rise of each axis, both positive; infinite on a side without a limit.

    Raises:
        ShapeError: Another number of axes.
        DesignError: Rates that do not let an input stay as it is.
    """
    if rate is None and low is None and high is None:
        return None, None
    both = (inf,) * m
    if rate is not None:
        both = _each_axis("input_rate_bound_per_s", rate, m)
        for one in both:
            require_positive("input_rate_bound_per_s", one)
    fall = both if low is None else tuple(-one for one in _each_axis("input_rate_low_per_s", low, m))
    rise = both if high is None else _each_axis("input_rate_high_per_s", high, m)
    if not all(one > 0.0 for one in (*fall, *rise)):
        got = f"{[-one for one in fall]}, {list(rise)}"
        raise DesignError("input_rate_low_per_s, input_rate_high_per_s", got, "negative and positive")
    return fall, rise


def _each_axis(name: str, value: PerAxis | None, m: int) -> tuple[float, ...]:
    given = numbers(name, value)
    each = given * m if is_one_number(value) else given
    if len(each) != m:
        raise ShapeError(name, f"{len(each)} numbers", f"one number, or {m}: one for each axis")
    return each


def each_of(name: str, given: Sequence[Kind], kind: type[Kind]) -> tuple[Kind, ...]:
    """Return a sequence as a tuple, if all in it are of one kind.

    Raises:
        DesignError: They are not.
    """
    found = members(given)
    if found is None or not all(isinstance(one, kind) for one in found):
        raise DesignError(name, described(given), f"a sequence of {kind.__name__}")
    return tuple(one for one in found if isinstance(one, kind))
