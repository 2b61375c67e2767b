"""The schema of experiment files: pydantic models with ranges, no unknown keys."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, JsonValue, field_validator, model_validator

from passafe_services.scenarios.fields import Config, Finite, no_flag
from passafe_services.scenarios.schema import Scenario
from passafe_services.suggestion import suggestion
from passafe_services.tools.experiment.axes import NAME, AnyAxis, BisectAxis, GridAxis, Overrides, RandomAxis
from passafe_services.tools.experiment.metrics import NUMERIC, Metrics

MOST_CELLS: Final = 10_000
MOST_RUNS: Final = 1_000_000

BASE: Final = "base"
"""Name of the only variant of an experiment that names none."""

_RESERVED: Final = frozenset({"variant", "seed", "error", "wall_s", "runs", *Metrics.model_fields, *NUMERIC})

_SECTIONS: Final = frozenset(
    name for name, field in Scenario.model_fields.items() if field.annotation not in {str, float, int}
)


class Seeds(Config):
    """Runs of every cell: one for each seed from ``first`` on."""

    first: Annotated[int, Field(ge=0, le=2**40)] = 0
    count: Annotated[int, Field(ge=1, le=MOST_RUNS)] = 1

    @property
    def all(self) -> range:
        """Every seed."""
        return range(self.first, self.first + self.count)


class Criterion(Config):
    """A metric of a run and the limit that it must keep; a metric that there is not keeps none."""

    metric: str
    at_least: Finite | None = None
    at_most: Finite | None = None

    @field_validator("metric")
    @classmethod
    def _is_a_metric(cls, metric: str) -> str:
        if metric not in NUMERIC:
            raise ValueError(f"got {metric!r}, allowed one of {', '.join(NUMERIC)}{suggestion(metric, NUMERIC)}")
        return metric

    @model_validator(mode="after")
    def _has_one_limit(self) -> Self:
        if (self.at_least is None) == (self.at_most is None):
            raise ValueError("at_least, at_most: got both or neither, allowed one of them")
        return self

    def holds(self, metrics: Metrics | None) -> bool:
        """Return whether a run keeps it; one that ended with an error does not."""
        value = None if metrics is None else metrics.number(self.metric)
        if value is None:
            return False
        return value >= self.at_least if self.at_least is not None else value <= (self.at_most or 0.0)

    def __str__(self) -> str:
        return f"{self.metric} ≥ {self.at_least:g}" if self.at_most is None else f"{self.metric} ≤ {self.at_most:g}"


class Experiment(Config):
    """One experiment: a scenario, what is varied, how often each cell is run and what is asked.

    Attributes:
        schema_version: Of this file's format.
        name: Short name.
        title: In words.
        description: More words.
        scenario: Shipped scenario, or a file beside the experiment's.
        start: ``scenario``: every run begins at its x0. ``random``: at a state that the cell's rows protect, drawn
            for each seed from the box of the scenario; modes and links make no difference to it.
        tracking: Whether every run is compared with the same one without injected links, which costs that run too.
        overrides: Values in place of the scenario's, in all runs.
        variants: Named sets of further overrides: every cell is run with each.
        seeds: Runs of every cell. A run's seed decides its random axes, links, start and operator.
        axes: What is varied, at most one of them bisected.
        criteria: What is asked of every run, by name.
        worst_by: Name of the criterion by whose metric the worst run of a cell is chosen.
    """

    schema_version: Annotated[Literal[2], BeforeValidator(no_flag)]
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,59}$")]
    title: str
    description: str = ""
    scenario: str
    start: Literal["scenario", "random"] = "scenario"
    tracking: bool = False
    overrides: Overrides = Field(default_factory=dict)
    variants: Annotated[dict[Annotated[str, Field(pattern=NAME)], Overrides], Field(min_length=1)] = Field(
        default_factory=lambda: {BASE: Overrides()}
    )
    seeds: Seeds = Seeds()
    axes: tuple[AnyAxis, ...] = ()
    criteria: Annotated[dict[Annotated[str, Field(pattern=NAME)], Criterion], Field(min_length=1)] = Field(
        default_factory=lambda: {
            "safe": Criterion(metric="h_min", at_least=0.0),
            "solvent": Criterion(metric="tank_min_j", at_least=0.0),
        }
    )
    worst_by: str = ""

    @property
    def grid(self) -> tuple[GridAxis, ...]:
        """Axes with listed values."""
        return tuple(axis for axis in self.axes if isinstance(axis, GridAxis))

    @property
    def random(self) -> tuple[RandomAxis, ...]:
        """Axes with a value for each seed."""
        return tuple(axis for axis in self.axes if isinstance(axis, RandomAxis))

    @property
    def bisected(self) -> BisectAxis | None:
        """The axis that is bisected, if one is."""
        return next((axis for axis in self.axes if isinstance(axis, BisectAxis)), None)

    @property
    def worst(self) -> Criterion:
        """The criterion by whose metric the worst run is chosen."""
        return self.criteria[self.worst_by or next(iter(self.criteria))]

    def overrides_of(self, variant: str, values: Mapping[str, JsonValue]) -> Overrides:
        """Return every override of a run: the experiment's, the variant's, then those of the axes in their order."""
        found = self.overrides | self.variants[variant]
        for axis in self.axes:
            found |= axis.overrides(values[axis.name])
        return found

    @field_validator("overrides", "variants", mode="after")
    @classmethod
    def _names_are_dotted(cls, overrides: dict[str, Any]) -> dict[str, Any]:
        for one in (overrides, *(value for value in overrides.values() if isinstance(value, dict))):
            for key, value in one.items():
                if key in _SECTIONS and isinstance(value, dict):
                    raise ValueError(f'got a table {key!r}, allowed dotted names in quotes such as "filter.mode"')
        return overrides

    @model_validator(mode="after")
    def _axes_go_together(self) -> Self:
        names = [axis.name for axis in self.axes]
        for name in names:
            if names.count(name) > 1 or name in _RESERVED:
                raise ValueError(f"axes: got the name {name!r}, allowed each name once and none of the results' own")
        keys = [key for axis in self.axes for key in axis.dotted]
        for key in keys:
            if keys.count(key) > 1:
                raise ValueError(f"axes: got {key!r} in two of them, allowed in one")
        if sum(isinstance(axis, BisectAxis) for axis in self.axes) > 1:
            raise ValueError("axes: got several that are bisected, allowed one")
        return self

    @model_validator(mode="after")
    def _has_a_worst(self) -> Self:
        if self.worst_by and self.worst_by not in self.criteria:
            near = suggestion(self.worst_by, self.criteria)
            raise ValueError(f"worst_by: got {self.worst_by!r}, allowed one of {', '.join(self.criteria)}{near}")
        if not self.tracking:
            for name, criterion in self.criteria.items():
                if criterion.metric.startswith("tracking_") or criterion.metric == "final_error":
                    raise ValueError(f"criteria.{name}: got {criterion.metric}, allowed with tracking = true only")
        return self

    @model_validator(mode="after")
    def _is_not_too_large(self) -> Self:
        cells = len(self.variants)
        for axis in self.grid:
            cells *= len(axis.values)
        if cells > MOST_CELLS:
            raise ValueError(f"axes: got {cells} cells, allowed up to {MOST_CELLS}")
        if cells * self.seeds.count > MOST_RUNS:
            raise ValueError(f"seeds.count: got {cells * self.seeds.count} runs, allowed up to {MOST_RUNS}")
        return self
