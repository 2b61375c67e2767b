"""Kinds of fields that every part of a scenario is made of."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Vector = Annotated[tuple[float, ...], Field(min_length=1, max_length=64)]
Positive = Annotated[float, Field(gt=0, le=1e6)]
NonNegative = Annotated[float, Field(ge=0, le=1e6)]
Finite = Annotated[float, Field(ge=-1e6, le=1e6)]


class Config(BaseModel):
    """Base of every part of a scenario: immutable, finite numbers only, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
