"""Kinds of fields that every part of a scenario is made of."""

from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field

Vector = Annotated[tuple[float, ...], Field(min_length=1, max_length=64)]
Positive = Annotated[float, Field(gt=0, le=1e6)]
NonNegative = Annotated[float, Field(ge=0, le=1e6)]
Finite = Annotated[float, Field(ge=-1e6, le=1e6)]
Place = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=2)]
"""A place, displacement or velocity in the plane."""


SINGLE: Final = "single"
LISTED: Final = "listed"
"""Names of the two forms of a field that is one number or a list; no file holds them."""


def single_or_listed(value: object) -> str:
    """Return which form a value has, so that only problems of that form are reported."""
    return LISTED if isinstance(value, list | tuple) else SINGLE


class Config(BaseModel):
    """Base of every part of a scenario: immutable, finite numbers only, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def require_above(field: str, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    """Refuse limits without an inside.

    Raises:
        ValueError: Not as many numbers in both, or a high that is not above its low.
    """
    if len(low) != len(high) or any(top <= bottom for bottom, top in zip(low, high, strict=True)):
        raise ValueError(f"{field}: got {low}, {high}, allowed as many numbers in both, every high above its low")
