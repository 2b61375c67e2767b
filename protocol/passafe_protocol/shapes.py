"""Fields of each record type by kind, read once from the annotations; codec, validation and JSON are driven by it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from operator import attrgetter
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

from passafe_protocol.messages import Record, Vector

RecordType: TypeAlias = type[Record]


@dataclass(frozen=True, kw_only=True, slots=True)
class Shape:
    """Fields of one record type by kind; each entry begins with the index of the field in the record and its name.

    Attributes:
        record_type: The record type.
        names: Names of the fields, in order.
        make: Constructs a record from the values of its fields, in order.
        read: Returns the values of the fields, in order, of any object with attributes of these names.
        plain: Fields that need no conversion for protobuf: numbers, booleans, strings, enum values.
        floats: Floats among ``plain``.
        enums: Enum values among ``plain``, with the members by number.
        vectors: Tuples of floats.
        parts: Records within the record, with their shapes.
        lists: Tuples of records, with the shape of an element.
    """

    record_type: RecordType
    names: tuple[str, ...]
    make: Callable[..., Record]
    read: Callable[[object], tuple[Any, ...]]
    plain: tuple[tuple[int, str], ...]
    floats: tuple[tuple[int, str], ...]
    enums: tuple[tuple[int, str, dict[int, IntEnum]], ...]
    vectors: tuple[tuple[int, str], ...]
    parts: tuple[tuple[int, str, "Shape"], ...]
    lists: tuple[tuple[int, str, "Shape"], ...]


@cache
def shape_of(record_type: RecordType) -> Shape:
    """Return the shape of a record type of ``passafe_protocol.messages``."""
    plain, floats, enums, vectors, parts, lists = [], [], [], [], [], []
    hints = get_type_hints(record_type)
    for index, (name, hint) in enumerate(hints.items()):
        if hint == Vector:
            vectors.append((index, name))
        elif get_origin(hint) is tuple:
            lists.append((index, name, shape_of(get_args(hint)[0])))
        elif issubclass(hint, Record):
            parts.append((index, name, shape_of(hint)))
        else:
            plain.append((index, name))
            if hint is float:
                floats.append((index, name))
            if issubclass(hint, IntEnum):
                enums.append((index, name, {member.value: member for member in hint}))
    return Shape(
        record_type=record_type,
        names=tuple(hints),
        make=record_type,
        read=_reader(tuple(hints)),
        plain=tuple(plain),
        floats=tuple(floats),
        enums=tuple(enums),
        vectors=tuple(vectors),
        parts=tuple(parts),
        lists=tuple(lists),
    )


def _reader(names: tuple[str, ...]) -> Callable[[object], tuple[Any, ...]]:
    """Return a function that reads these fields of an object; ``attrgetter`` returns no tuple of a single one."""
    if len(names) > 1:
        return attrgetter(*names)
    [name] = names
    return lambda record: (getattr(record, name),)


def as_dict(record: Record) -> dict[str, Any]:
    """Convert a record and the records within it into dictionaries of JSON values."""
    shape = shape_of(type(record))
    values = dict(zip(shape.names, shape.read(record), strict=True))
    for _, name, _ in shape.parts:
        values[name] = as_dict(values[name])
    for _, name, _ in shape.lists:
        values[name] = [as_dict(element) for element in values[name]]
    return values
