"""The runs that an experiment still wants, from what is known so far: the same in whatever order results come."""

from collections.abc import Iterable, Iterator, Mapping

from passafe_services.tools.experiment.bisection import first_values, most_values, next_value
from passafe_services.tools.experiment.cells import Cell, Run, RunKey, cells_of, run_of
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.schema import Experiment


class Plan:
    """The runs of one experiment.

    Attributes:
        experiment: The experiment.
        cells: Its cells.
        results: What is known of the seeds that are asked for, by key.
    """

    def __init__(self, experiment: Experiment, results: Mapping[RunKey, RunResult] | None = None) -> None:
        """Begin with what is known.

        Args:
            experiment: The experiment.
            results: Results from before.
        """
        self.experiment = experiment
        self.cells = cells_of(experiment)
        self.results: dict[RunKey, RunResult] = {}
        self._of_cell: dict[int, list[RunResult]] = {cell.number: [] for cell in self.cells}
        self._asked: set[RunKey] = set()
        self._open: dict[int, int] = {}
        seeds = experiment.seeds.all
        for key, result in (results or {}).items():
            if key.seed in seeds:
                self._add(result)

    def first(self) -> Iterator[Run]:
        """Yield every run that is wanted now, cell by cell within a variant and seed.

        Runs of one variant share what is compiled, runs of one seed their reference; so they come one after the other.
        """
        wanted = [run for cell in self.cells for run in self._wanted(cell)]
        order = {name: number for number, name in enumerate(self.experiment.variants)}
        yield from sorted(wanted, key=lambda run: (order[run.variant], run.seed, run.cell, run.probe or 0.0))

    def after(self, result: RunResult) -> list[Run]:
        """Add a result; return the runs that are wanted because of it."""
        self._add(result)
        cell = result.run.cell
        self._open[cell] -= 1
        return [] if self._open[cell] else self._wanted(self.cells[cell])

    @property
    def most_runs(self) -> int:
        """Largest number of runs in all, those that are known among them."""
        axis, seeds = self.experiment.bisected, self.experiment.seeds.count
        if axis is None:
            return len(self.cells) * seeds
        most = most_values(axis, len(self.experiment.criteria)) * seeds
        return sum(
            max(most, len(found)) if self._open.get(number, most) else len(found)
            for number, found in self._of_cell.items()
        )

    @property
    def is_complete(self) -> bool:
        """True if no run is wanted any more."""
        return not any(self._missing(cell) for cell in self.cells)

    def holds(self, cell: Cell) -> dict[str, dict[float, bool]]:
        """Return for every criterion whether it holds in all runs of a cell, by value of the bisected axis.

        Values of which a run is missing are left out.
        """
        by_value: dict[float, list[RunResult]] = {}
        for result in self._of_cell[cell.number]:
            if result.run.probe is not None:
                by_value.setdefault(result.run.probe, []).append(result)
        whole = {value: found for value, found in by_value.items() if len(found) == self.experiment.seeds.count}
        return {
            name: {value: all(criterion.holds(one.metrics) for one in found) for value, found in whole.items()}
            for name, criterion in self.experiment.criteria.items()
        }

    def _wanted(self, cell: Cell) -> list[Run]:
        wanted = self._missing(cell)
        self._asked |= {run.key for run in wanted}
        self._open[cell.number] = len(wanted)
        return wanted

    def _missing(self, cell: Cell) -> list[Run]:
        """Return the runs of a cell that are neither known nor asked for."""
        return [
            run_of(self.experiment, cell, seed, probe)
            for probe in self._probes(cell)
            for seed in self.experiment.seeds.all
            if RunKey(cell.number, probe, seed) not in self.results
            and RunKey(cell.number, probe, seed) not in self._asked
        ]

    def _probes(self, cell: Cell) -> Iterable[float | None]:
        axis = self.experiment.bisected
        if axis is None:
            return [None]
        holds = self.holds(cell)
        first = first_values(axis)
        if any(value not in found for value in first for found in holds.values()):
            return first
        following = (next_value(axis, found) for found in holds.values())
        return sorted({value for value in following if value is not None})

    def _add(self, result: RunResult) -> None:
        self.results[result.run.key] = result
        self._of_cell[result.run.cell].append(result)
