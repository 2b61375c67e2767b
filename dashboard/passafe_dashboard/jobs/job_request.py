"""Requests for work, as the page sends them and as a job's process reads them."""

import re
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator

NameText = Annotated[str, Field(min_length=1, max_length=1024)]
ChangeValue = bool | int | FiniteFloat | Annotated[str, Field(max_length=200)] | tuple[FiniteFloat, ...]

MOST_CHANGES: Final = 32
CHANGED: Final = re.compile(r"(?:filter|plant|links)\.[A-Za-z0-9_.-]{1,190}|rate_hz")
"""Keys of a scenario that the page may change: none that makes a run longer."""

FILES: Final = (".trace", ".path")
"""Ends of keys that name a file, which a page may not choose."""


class JobRequest(BaseModel):
    """Base of all requests."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class ReviewRequest(JobRequest):
    """A review of one log.

    Attributes:
        kind: Tells the requests apart.
        log: Name of the log in the runs folder.
    """

    kind: Literal["review"]
    log: NameText


class CompareRequest(JobRequest):
    """A comparison of runs, drawn over one another.

    Attributes:
        kind: Tells the requests apart.
        logs: Names of the logs; the first is the reference.
        align: What counts as the same moment in each: start, first-input or event:KIND.
    """

    kind: Literal["compare"]
    logs: Annotated[tuple[NameText, ...], Field(min_length=2, max_length=2)]
    align: Annotated[str, Field(max_length=200)] = "start"


class WhatIfRequest(JobRequest):
    """A re-run of a log with something changed; its log is written beside the other.

    Attributes:
        kind: Tells the requests apart.
        log: Name of the log in the runs folder.
        changes: Values of the scenario by dotted name, such as ``links.plant-to-filter.delay_s``.
        operator: Who drives: the commands in the log, or the scenario's own source.
        links: Whether unchanged links do what they did in the log, or draw anew.
    """

    kind: Literal["what-if"]
    log: NameText
    changes: Annotated[dict[str, ChangeValue], Field(max_length=MOST_CHANGES)] = Field(default_factory=dict)
    operator: Literal["recorded", "scenario"] = "recorded"
    links: Literal["recorded", "drawn"] = "recorded"

    @field_validator("changes")
    @classmethod
    def _are_changes_of_a_run(cls, changes: dict[str, ChangeValue]) -> dict[str, ChangeValue]:
        for key in changes:
            if CHANGED.fullmatch(key) is None or key.endswith(FILES):
                raise ValueError(f"got the key {key[:80]!a}, allowed rate_hz and keys of filter, plant and links")
        return changes


class CellRunRequest(JobRequest):
    """A run of an experiment, repeated with a recorder.

    Attributes:
        kind: Tells the requests apart.
        experiment: Name of the experiment's folder in the runs folder.
        cell: Number of the cell.
        probe: Value of the axis that is bisected, if one is.
        seed: Seed of the run.
    """

    kind: Literal["cell-run"]
    experiment: NameText
    cell: Annotated[int, Field(ge=0, lt=10_000)]
    probe: FiniteFloat | None = None
    seed: Annotated[int, Field(ge=0, lt=2**41)]


class SweepRequest(JobRequest):
    """A sweep of an experiment, begun or resumed.

    Attributes:
        kind: Tells the requests apart.
        source: ``shipped``: an experiment that comes with passafe. ``file``: one in the runs folder. ``folder``: one
            whose results are in the runs folder, and of which runs are missing.
        experiment: Its name; of a file or folder, the name in the runs folder.
        seeds: Runs of every cell; those of the experiment if not given.
    """

    kind: Literal["sweep"]
    source: Literal["shipped", "file", "folder"]
    experiment: NameText
    seeds: Annotated[int, Field(ge=1, le=1_000_000)] | None = None


AnyJobRequest = Annotated[
    ReviewRequest | CompareRequest | WhatIfRequest | CellRunRequest | SweepRequest, Field(discriminator="kind")
]
