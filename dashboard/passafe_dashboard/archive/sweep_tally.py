"""Count the results of a sweep as they come: by cell, how many runs break a criterion, and which run is the worst."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, Final

from passafe_services.tools.experiment.metrics import STEERING
from passafe_services.tools.experiment.schema import Criterion, Experiment
from passafe_services.tools.experiment.summary import VERDICT
from passafe_services.tools.runs.summary import badness


@dataclass(kw_only=True)
class ProbeTally:
    """Runs of one cell, at one value of the bisected axis where there is one.

    Attributes:
        runs: How many there are.
        errors: How many could not be run.
        breaking: How many break each criterion, by its name, and the verdict.
        low: Lowest value of each metric that a criterion asks about.
        high: Highest value of the same.
        worst_seed: Seed of the worst run by the experiment's ``worst_by``.
        worst: Its metric; ``None`` where it has none.
    """

    runs: int = 0
    errors: int = 0
    breaking: dict[str, int] = field(default_factory=dict)
    low: dict[str, float] = field(default_factory=dict)
    high: dict[str, float] = field(default_factory=dict)
    worst_seed: int = -1
    worst: float | None = None
    badness: float = -inf


class SweepTally:
    """Results of a sweep, counted.

    Args:
        experiment: The experiment.

    Attributes:
        runs: How many results there are.
        errors: How many runs could not be run.
        cells: Tallies by cell, then by value of the bisected axis.
    """

    def __init__(self, experiment: Experiment) -> None:
        self.experiment = experiment
        self.runs = self.errors = 0
        self.cells: dict[int, dict[float | None, ProbeTally]] = {}
        self._metrics: Final = tuple(dict.fromkeys(criterion.metric for criterion in experiment.criteria.values()))

    def add(self, line: bytes) -> None:
        """Add a line of the results file.

        Raises:
            ValueError: It is no result.
        """
        try:
            result = json.loads(line)
            run, metrics = result["run"], result["metrics"]
            cell, probe, seed = int(run["cell"]), run["probe"], int(run["seed"])
            values = {} if metrics is None else {name: _number(metrics, name) for name in self._metrics}
        except (KeyError, TypeError) as error:
            raise ValueError(f"no result: {error}") from error
        self.runs += 1
        tally = self.cells.setdefault(cell, {}).setdefault(probe, ProbeTally())
        tally.runs += 1
        if metrics is None:
            tally.errors += 1
            self.errors += 1
        self._count(tally, values, holds=metrics is not None and metrics.get("verdict") == "holds")
        worst = self.experiment.worst
        value = values.get(worst.metric)
        bad = badness(value, high_is_worse=worst.at_most is not None)
        if bad > tally.badness or (bad == tally.badness and seed < tally.worst_seed):
            tally.badness, tally.worst, tally.worst_seed = bad, value, seed

    def _count(self, tally: ProbeTally, values: Mapping[str, float | None], *, holds: bool) -> None:
        for name, criterion in self.experiment.criteria.items():
            tally.breaking[name] = tally.breaking.get(name, 0) + (not _keeps(criterion, values.get(criterion.metric)))
        tally.breaking[VERDICT] = tally.breaking.get(VERDICT, 0) + (not holds)
        for name, value in values.items():
            if value is not None:
                tally.low[name] = min(value, tally.low.get(name, inf))
                tally.high[name] = max(value, tally.high.get(name, -inf))


def _number(metrics: Mapping[str, Any], name: str) -> float | None:
    if name in STEERING:
        steering = metrics.get("steering")
        value = None if steering is None else steering[STEERING[name]]
    else:
        value = metrics[name]
    return None if value is None else float(value)


def _keeps(criterion: Criterion, value: float | None) -> bool:
    if value is None:
        return False
    return value >= criterion.at_least if criterion.at_least is not None else value <= (criterion.at_most or 0.0)
