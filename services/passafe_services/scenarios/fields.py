"""Kinds of fields that every part of a scenario is made of."""

from collections.abc import Callable, Iterable
from typing import Annotated, Final, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, JsonValue

Vector = Annotated[tuple[float, ...], Field(min_length=1, max_length=64)]
Positive = Annotated[float, Field(gt=0, le=1e6)]
NonNegative = Annotated[float, Field(ge=0, le=1e6)]
Finite = Annotated[float, Field(ge=-1e6, le=1e6)]
Place = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=2)]
"""A place, displacement or velocity in the plane."""


DEEPEST: Final = 64
"""Tables and lists within one another that are looked into."""

SINGLE: Final = "single"
LISTED: Final = "listed"
"""Names of the two forms of a field that is one number or a list; no file holds them."""


def single_or_listed(value: object) -> str:
    """Return which form a value has, so that only problems of that form are reported."""
    return LISTED if isinstance(value, list | tuple) else SINGLE


class Config(BaseModel):
    """Base of every part of a scenario: immutable, finite numbers only, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @classmethod
    def of_file(cls, data: object) -> Self:
        """Return what parsed TOML or JSON holds, and convert nothing: ``true`` and ``"1"`` are no numbers.

        Raises:
            ValidationError: A field that holds what it may not.
        """
        return cls.model_validate(_nested(data, tuple), strict=True)


def _nested(value: object, kind: Callable[[Iterable[object]], object], depth: int = 0) -> object:
    """Return a value with another kind of list in it; what lies too deep fits no field."""
    if isinstance(value, dict) and depth < DEEPEST:
        return {key: _nested(entry, kind, depth + 1) for key, entry in value.items()}
    if isinstance(value, list | tuple) and depth < DEEPEST:
        return kind(_nested(entry, kind, depth + 1) for entry in value)
    return value


def no_flag(value: object) -> object:
    """Return a value, unless it is a flag: Python takes ``true`` for 1.

    Raises:
        ValueError: It is one.
    """
    if value is True or value is False:
        raise ValueError(f"got {str(value).lower()}, allowed a whole number")
    return value


AnyValue = Annotated[JsonValue, BeforeValidator(lambda value: _nested(value, list))]
"""A value of another file's key, which is checked there."""


def require_above(field: str, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    """Refuse limits without an inside.

    Raises:
        ValueError: Not as many numbers in both, or a high that is not above its low.
    """
    if len(low) != len(high) or any(top <= bottom for bottom, top in zip(low, high, strict=True)):
        raise ValueError(f"{field}: got {low}, {high}, allowed as many numbers in both, every high above its low")
