"""What each message tuple is made of, read once from its annotations.

Codec, validation and the generated documentation are driven by it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cache, partial
from operator import attrgetter
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

from protocol.messages import Vector

TupleType: TypeAlias = type[tuple[Any, ...]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Shape:
    """Fields of one tuple type by kind; each entry begins with the field's place in the tuple and its name.

    Attributes:
        tuple_type: The type itself.
        make: Makes a tuple of the type from the values of its fields, in order.
        read: Values of the fields, in order, of anything that has attributes of their names.
        plain: Fields that protobuf takes and gives as they are: numbers, booleans, strings, enum values.
        floats: Those of ``plain`` that are floats.
        enums: Those of ``plain`` that are enum values, with the members by number.
        vectors: Tuples of floats.
        parts: Tuples within the tuple, with their shapes.
        lists: Tuples of tuples, with the shape of an element.
    """

    tuple_type: TupleType
    make: Callable[[list[Any]], tuple[Any, ...]]
    read: Callable[[object], tuple[Any, ...]]
    plain: tuple[tuple[int, str], ...]
    floats: tuple[tuple[int, str], ...]
    enums: tuple[tuple[int, str, dict[int, IntEnum]], ...]
    vectors: tuple[tuple[int, str], ...]
    parts: tuple[tuple[int, str, "Shape"], ...]
    lists: tuple[tuple[int, str, "Shape"], ...]


@cache
def shape_of(tuple_type: TupleType) -> Shape:
    """Shape of a named tuple type of ``protocol.messages``."""
    plain, floats, enums, vectors, parts, lists = [], [], [], [], [], []
    hints = get_type_hints(tuple_type)
    for index, (name, hint) in enumerate(hints.items()):
        if hint == Vector:
            vectors.append((index, name))
        elif get_origin(hint) is tuple:
            lists.append((index, name, shape_of(get_args(hint)[0])))
        elif issubclass(hint, tuple):
            parts.append((index, name, shape_of(hint)))
        else:
            plain.append((index, name))
            if hint is float:
                floats.append((index, name))
            if issubclass(hint, IntEnum):
                enums.append((index, name, {member.value: member for member in hint}))
    return Shape(
        tuple_type=tuple_type,
        make=partial(tuple.__new__, tuple_type),
        read=attrgetter(*hints),
        plain=tuple(plain),
        floats=tuple(floats),
        enums=tuple(enums),
        vectors=tuple(vectors),
        parts=tuple(parts),
        lists=tuple(lists),
    )
