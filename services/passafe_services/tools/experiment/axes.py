"""Axes of an experiment: listed values, values drawn for each seed, and one that is bisected."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self, TypeAlias
from zlib import crc32

import numpy as np
from pydantic import Discriminator, Field, JsonValue, Tag, model_validator

from passafe_services.scenarios.fields import AnyValue, Config, Finite, Positive

Overrides: TypeAlias = dict[str, AnyValue]
"""Values of a scenario by dotted name, as ``load_scenario`` takes them."""

NAME: Final = r"^[A-Za-z][A-Za-z0-9_.-]{0,79}$"

_LEAST_VALUES: Final = 1


class Axis(Config):
    """Something that is varied: one value of a scenario, or several at once.

    Attributes:
        name: Its column in the results; that of ``key`` if not given.
        key: Dotted name of the value.
        keys: Dotted names of several values that go together: a list, each takes the axis' value; or a table, each
            takes it times a factor.
    """

    name: Annotated[str, Field(pattern=NAME)] = ""
    key: str | None = None
    keys: tuple[str, ...] | dict[str, Finite] | None = None

    @model_validator(mode="before")
    @classmethod
    def _is_named_after_its_key(cls, data: Any) -> Any:  # noqa: ANN401 - TOML may hold anything; the fields report what is wrong
        if isinstance(data, Mapping) and not data.get("name") and isinstance(data.get("key"), str):
            return {**data, "name": data["key"]}
        return data

    @model_validator(mode="after")
    def _has_one_of_key_and_keys(self) -> Self:
        if (self.key is None) == (not self.keys):
            raise ValueError("key, keys: got both or neither, allowed one of them")
        if not self.name:
            raise ValueError("name: got none, allowed a name where the axis has keys")
        return self

    @property
    def dotted(self) -> tuple[str, ...]:
        """Names of all values that it sets."""
        return tuple(self.keys or ()) if self.key is None else (self.key,)

    @property
    def scales(self) -> bool:
        """True if it sets multiples of its value, which then must be a number."""
        return isinstance(self.keys, dict)

    def overrides(self, value: JsonValue) -> Overrides:
        """Return what one value of the axis sets."""
        if isinstance(self.keys, dict) and isinstance(value, int | float):
            return {key: factor * value for key, factor in self.keys.items()}
        return dict.fromkeys(self.dotted, value)


class GridAxis(Axis):
    """Takes each of its values in turn; every combination with the other grid axes is a cell."""

    kind: Literal["grid"] = "grid"
    values: Annotated[tuple[AnyValue, ...], Field(min_length=_LEAST_VALUES, max_length=1000)]

    @model_validator(mode="after")
    def _values_differ_and_scale(self) -> Self:
        if any(value in self.values[:k] for k, value in enumerate(self.values)):
            raise ValueError(f"values: got {list(self.values)}, allowed each value once")
        if self.scales and not all(isinstance(value, int | float) for value in self.values):
            raise ValueError(f"values: got {list(self.values)}, allowed numbers, since keys has factors")
        return self


class RandomAxis(Axis):
    """Takes another value for each seed, the same one in every cell.

    Attributes:
        seed: Another one draws other values.
    """

    seed: Annotated[int, Field(ge=0, lt=2**32)] = 0

    def draw(self, run_seed: int) -> JsonValue:
        """Return the axis' value for one seed of the experiment: it depends on both seeds and the axis' name."""
        return self._draw(np.random.default_rng([self.seed, crc32(self.name.encode()), run_seed]))

    def _draw(self, rng: np.random.Generator) -> JsonValue:
        raise NotImplementedError


class UniformAxis(RandomAxis):
    """Uniform in [low, high]."""

    kind: Literal["uniform"]
    low: Finite
    high: Finite

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        _require_room(self.low, self.high)
        return self

    def _draw(self, rng: np.random.Generator) -> JsonValue:
        return float(rng.uniform(self.low, self.high))


class LogUniformAxis(RandomAxis):
    """Its logarithm is uniform: every factor is as likely anywhere in [low, high]."""

    kind: Literal["log-uniform"]
    low: Positive
    high: Positive

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        _require_room(self.low, self.high)
        return self

    def _draw(self, rng: np.random.Generator) -> JsonValue:
        return float(np.exp(rng.uniform(np.log(self.low), np.log(self.high))))


class ChoiceAxis(RandomAxis):
    """One of its values, each as likely."""

    kind: Literal["choice"]
    values: Annotated[tuple[AnyValue, ...], Field(min_length=_LEAST_VALUES, max_length=1000)]

    def _draw(self, rng: np.random.Generator) -> JsonValue:
        return self.values[int(rng.integers(len(self.values)))]


class BisectAxis(Axis):
    """Is searched, in every cell, for the least value at which a criterion fails.

    Both ends and ``scan`` values evenly spread between them are tried first; the first step from a value that holds to
    one that fails is then halved until it is no wider than ``tolerance``, or ``steps`` times. A criterion that holds
    again beyond the first failure is called not monotone.
    """

    kind: Literal["bisect"]
    low: Finite
    high: Finite
    tolerance: Positive | None = None
    steps: Annotated[int, Field(ge=1, le=40)] | None = None
    scan: Annotated[int, Field(ge=0, le=100)] = 3

    @model_validator(mode="after")
    def _ends_somewhere(self) -> Self:
        if (self.tolerance is None) == (self.steps is None):
            raise ValueError("tolerance, steps: got both or neither, allowed one of them")
        _require_room(self.low, self.high)
        return self

    @property
    def widest(self) -> float:
        """Width of a bracket that is narrow enough."""
        if self.tolerance is not None:
            return self.tolerance
        return (self.high - self.low) / (self.scan + 1) / 2.0 ** (self.steps or 0)


def _require_room(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low, high: got {low:g} and {high:g}, allowed a low below its high")


def _kind_of(data: Any) -> Any:  # noqa: ANN401 - TOML may hold anything; pydantic reports what is wrong with it
    return data.get("kind", "grid") if isinstance(data, Mapping) else getattr(data, "kind", None)


AnyAxis = Annotated[
    Annotated[GridAxis, Tag("grid")]
    | Annotated[UniformAxis, Tag("uniform")]
    | Annotated[LogUniformAxis, Tag("log-uniform")]
    | Annotated[ChoiceAxis, Tag("choice")]
    | Annotated[BisectAxis, Tag("bisect")],
    Discriminator(_kind_of),
]
