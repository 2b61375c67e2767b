"""Stages of a computation: named numbers, declared once and held in the form that a task needs."""

from collections.abc import Callable
from typing import Annotated, Any, Final, Generic, Self, TypeAlias, TypeVar, cast, get_type_hints

from msgspec import Struct

T = TypeVar("T")

_MATRIX: Final = "a matrix"
Matrix: TypeAlias = Annotated[T, _MATRIX]
"""Declares a field that has rows and columns; every other field is a vector."""


class Stage(Struct, Generic[T], frozen=True, eq=False, gc=False):
    """Base of the stages that a decision passes through.

    A subclass declares its fields, each of type T. The same class then holds a stage's expressions, from which CasADi's
    functions are made (T is ``ca.SX``), the views of its numbers in a block (``Array``), what writes them, or the
    numbers themselves (``float``). Names are attributes everywhere, so that the type checker knows them, and the order
    in memory is that of the declaration.
    """

    @classmethod
    def of(cls, make: Callable[[str], T]) -> Self:
        """Return the stage whose fields are made from their names."""
        return cast(Callable[..., Self], cls)(*map(make, cls.__struct_fields__))

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of the fields, in their order."""
        return cls.__struct_fields__

    @classmethod
    def matrices(cls) -> frozenset[str]:
        """Return the names of the fields that are matrices."""
        hints = get_type_hints(cls, include_extras=True)
        return frozenset(name for name in cls.names() if _MATRIX in getattr(hints[name], "__metadata__", ()))

    def fields(self) -> dict[str, T]:
        """Return the fields by name, in their order."""
        return {name: getattr(self, name) for name in self.__struct_fields__}


def part_names(*stages: type[Stage[Any]]) -> list[str]:
    """Return the names of all fields of some stages, in their order."""
    return [name for stage in stages for name in stage.names()]
