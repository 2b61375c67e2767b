"""Experiments in the runs folder as the page gets them: a list, and the map of each.

Beside a robot the page's server starts without what sweeps are made of, which takes a second to load.
"""

from typing import Literal

from pydantic import BaseModel, ConfigDict

SweepStage = Literal["running", "writing logs", "writing its report", "finished", "interrupted", "unknown"]


class _View(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SweepJob(_View):
    """The job of this server that runs an experiment, or ran it last.

    Attributes:
        job: Its id.
        state: waiting, running, done, failed or cancelled.
        text: What it does now, what is to be said of it, or why it failed.
    """

    job: str
    state: str
    text: str


class ExperimentEntry(_View):
    """One experiment of the list.

    Attributes:
        name: Name of its folder in the runs folder.
        title: Title of the experiment; empty if its results say none.
        stage: What its process does, or how it ended.
        runs: Results so far.
        most_runs: Largest number of runs in all; ``None`` if it is not known.
        modified_s: Unix time of the last result, s.
        trouble: Why it cannot be read; empty if it can.
        job: Job of this server that runs it, or ran it last; ``None`` if none did.
    """

    name: str
    title: str
    stage: SweepStage
    runs: int
    most_runs: int | None
    modified_s: float
    trouble: str
    job: SweepJob | None = None


class ExperimentList(_View):
    """Experiments in the runs folder, the newest first."""

    experiments: tuple[ExperimentEntry, ...]


class AxisView(_View):
    """An axis with listed values, in words."""

    name: str
    values: tuple[str, ...]


class ProbeView(_View):
    """Runs of one cell, at one value of the bisected axis where there is one.

    Attributes:
        probe: That value.
        runs: How many there are.
        errors: How many could not be run.
        breaking: How many break each criterion, by its name, and the verdict.
        low: Lowest value of each metric that a criterion asks about.
        high: Highest value of the same.
        worst_seed: Seed of the worst run.
        worst: Its metric.
        log: Log of that run, by its name in the runs folder; ``None`` if there is none yet.
    """

    probe: float | None
    runs: int
    errors: int
    breaking: dict[str, int]
    low: dict[str, float]
    high: dict[str, float]
    worst_seed: int
    worst: float | None
    log: str | None


class CellView(_View):
    """One cell of the map.

    Attributes:
        number: Its number.
        variant: Name of its variant.
        values: Value of each listed axis, in words, in the order of the axes.
        probes: Its runs; empty before the first.
        boundaries: Where each criterion first fails along the bisected axis, in words; empty without one.
    """

    number: int
    variant: str
    values: tuple[str, ...]
    probes: tuple[ProbeView, ...]
    boundaries: dict[str, str]


class ExperimentView(_View):
    """The map of an experiment.

    Attributes:
        entry: What the list says of it.
        scenario: Scenario that it is about.
        criteria: What is asked of every run, in words, by name; ``verdict`` besides.
        metrics: Metric of each criterion, by its name.
        worst_by: Name of the criterion by which the worst run is chosen.
        variants: Names of the variants.
        axes: Axes with listed values.
        bisected: Name of the bisected axis; ``None`` without one.
        seeds: Runs of every cell and value; ``None`` if it is not known.
        is_behind: Whether there are results that have not been read yet.
        cells: Every cell, in order.
    """

    entry: ExperimentEntry
    scenario: str
    criteria: dict[str, str]
    metrics: dict[str, str]
    worst_by: str
    variants: tuple[str, ...]
    axes: tuple[AxisView, ...]
    bisected: str | None
    seeds: int | None
    is_behind: bool
    cells: tuple[CellView, ...]


class ExperimentOffer(_View):
    """An experiment that can be started.

    Attributes:
        source: ``shipped``, or ``file``: in the runs folder.
        experiment: Its name; of a file, that in the runs folder.
        title: In words.
        cells: Number of its cells.
        seeds: Runs of every cell, or of every cell and value of a bisected axis.
        most_runs: Largest number of runs in all with so many seeds.
        trouble: Why it cannot be read; empty if it can.
    """

    source: Literal["shipped", "file"]
    experiment: str
    title: str
    cells: int
    seeds: int
    most_runs: int
    trouble: str


class ExperimentOffers(_View):
    """Experiments that can be started.

    Attributes:
        offers: The shipped ones, then those in the runs folder.
        most_runs: Runs of the largest that the page starts.
    """

    offers: tuple[ExperimentOffer, ...]
    most_runs: int
