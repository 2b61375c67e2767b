"""First field in which two records differ, to the last bit."""

import textwrap
from collections.abc import Sequence
from enum import Enum
from itertools import zip_longest
from typing import Any, Final, NamedTuple

import msgspec

from passafe_protocol.messages import Record
from passafe_protocol.shapes import Shape, shape_of

SHOWN: Final = 120
"""Longest text of a value, characters."""

_bits = msgspec.msgpack.Encoder(enc_hook=int).encode  # unlike ==, it tells 0.0 from −0.0 and knows a NaN again


class FieldDifference(NamedTuple):
    """Field in which two records differ.

    Attributes:
        path: Its place, such as ``barriers[1].psi[0]``.
        before: Its value in the first record; ``None`` if it has no such element.
        after: The same in the second one.
    """

    path: str
    before: Any
    after: Any

    def __str__(self) -> str:
        return f"{self.path} {_text(self.before)} -> {_text(self.after)}"


def are_identical(first: Record, second: Record) -> bool:
    """Return whether two records are the same to the last bit."""
    return type(first) is type(second) and _bits(first) == _bits(second)


def field_differences(first: Record, second: Record) -> list[FieldDifference]:
    """Return every field in which two records of one type differ, in the order of their fields.

    Args:
        first: A record.
        second: Another one of its type.

    Raises:
        TypeError: They are of different types.
    """
    if type(first) is not type(second):
        raise TypeError(f"records: got {type(first).__name__} and {type(second).__name__}, allowed one type")
    found: list[FieldDifference] = []
    _compare(shape_of(type(first)), first, second, "", found)
    return found


def _compare(shape: Shape, first: Record, second: Record, path: str, found: list[FieldDifference]) -> None:
    parts, lists = ({name: of for _, name, of in kind} for kind in (shape.parts, shape.lists))
    for name, before, after in zip(shape.names, shape.read(first), shape.read(second), strict=True):
        place = path + name
        if name in parts:
            _compare(parts[name], before, after, f"{place}.", found)
        elif isinstance(before, tuple):
            _compare_lists(lists.get(name), before, after, place, found)
        elif _bits(before) != _bits(after):
            found.append(FieldDifference(place, before, after))


def _compare_lists(
    shape: Shape | None, before: Sequence[Any], after: Sequence[Any], place: str, found: list[FieldDifference]
) -> None:
    for k, (left, right) in enumerate(zip_longest(before, after)):
        if shape is not None and left is not None and right is not None:
            _compare(shape, left, right, f"{place}[{k}].", found)
        elif _bits(left) != _bits(right):
            found.append(FieldDifference(f"{place}[{k}]", left, right))


def _text(value: object) -> str:
    if value is None:
        return "nothing"
    text = value.name if isinstance(value, Enum) else repr(value)
    return textwrap.shorten(text, SHOWN, placeholder="…")
