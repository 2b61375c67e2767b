"""Describe an experiment for the page, from its results so far."""

from pathlib import Path
from typing import Final

from passafe_services.tools.experiment.bisection import Boundary
from passafe_services.tools.experiment.cells import Cell, RunKey, cells_of, displayed
from passafe_services.tools.experiment.kept_logs import log_name_of
from passafe_services.tools.experiment.schema import Experiment
from passafe_services.tools.experiment.summary import VERDICT
from passafe_services.tools.experiment.sweep_state import SweepState

from passafe_dashboard.archive.experiment_models import (
    AxisView,
    CellView,
    ExperimentEntry,
    ExperimentView,
    ProbeView,
    SweepStage,
)
from passafe_dashboard.archive.runs_folder import RESULTS
from passafe_dashboard.archive.sweep_reader import SweepReader
from passafe_dashboard.archive.sweep_tally import ProbeTally

_STAGES: Final[dict[str, SweepStage]] = {
    "runs": "running",
    "logs": "writing logs",
    "report": "writing its report",
}


def entry_of(name: str, folder: Path, reader: SweepReader) -> ExperimentEntry:
    """Return what the list says of an experiment."""
    state = SweepState.read(folder)
    try:
        modified_s = (folder / RESULTS).stat().st_mtime
    except OSError:
        modified_s = 0.0
    tally = reader.tally
    return ExperimentEntry(
        name=name,
        title="" if tally is None else tally.experiment.title or tally.experiment.name,
        stage=_stage(state),
        runs=0 if tally is None else tally.runs,
        most_runs=None if state is None else state.most_runs,
        modified_s=modified_s,
        trouble=reader.trouble,
    )


def view_of(name: str, folder: Path, reader: SweepReader) -> ExperimentView | None:
    """Return the map of an experiment; ``None`` if its results cannot be read."""
    tally = reader.tally
    if tally is None:
        return None
    experiment = tally.experiment
    state = SweepState.read(folder)
    seeds = None if state is None else state.seeds.count
    try:
        logs = {path.name for path in (folder / "logs").iterdir()}
    except OSError:
        logs = set()
    cells = tuple(
        CellView(
            number=cell.number,
            variant=cell.variant,
            values=tuple(map(displayed, cell.values.values())),
            probes=tuple(
                _probe(name, cell, probe, found, logs)
                for probe, found in sorted(tally.cells.get(cell.number, {}).items(), key=lambda item: item[0] or 0.0)
            ),
            boundaries=_boundaries(experiment, tally.cells.get(cell.number, {}), seeds),
        )
        for cell in cells_of(experiment)
    )
    return ExperimentView(
        entry=entry_of(name, folder, reader),
        scenario=experiment.scenario,
        criteria={key: str(criterion) for key, criterion in experiment.criteria.items()}
        | {VERDICT: "every property that its mode requires"},
        metrics={key: criterion.metric for key, criterion in experiment.criteria.items()},
        worst_by=experiment.worst_by or next(iter(experiment.criteria)),
        variants=tuple(experiment.variants),
        axes=tuple(AxisView(name=axis.name, values=tuple(map(displayed, axis.values))) for axis in experiment.grid),
        bisected=None if experiment.bisected is None else experiment.bisected.name,
        seeds=seeds,
        is_behind=reader.is_behind,
        cells=cells,
    )


def _stage(state: SweepState | None) -> SweepStage:
    if state is None:
        return "unknown"
    if state.runs_on:
        return _STAGES[state.stage]
    return "finished" if state.stage == "finished" else "interrupted"


def _probe(name: str, cell: Cell, probe: float | None, tally: ProbeTally, logs: set[str]) -> ProbeView:
    log = log_name_of(RunKey(cell.number, probe, tally.worst_seed))
    return ProbeView(
        probe=probe,
        runs=tally.runs,
        errors=tally.errors,
        breaking=dict(tally.breaking),
        low=dict(tally.low),
        high=dict(tally.high),
        worst_seed=tally.worst_seed,
        worst=tally.worst,
        log=f"{name}/logs/{log}" if log in logs else None,
    )


def _boundaries(experiment: Experiment, found: dict[float | None, ProbeTally], seeds: int | None) -> dict[str, str]:
    """Return where each criterion first fails, from the values of which every run is known."""
    if experiment.bisected is None:
        return {}
    wanted = seeds or max((tally.runs for tally in found.values()), default=0)
    whole = {probe: tally for probe, tally in found.items() if probe is not None and tally.runs >= wanted}
    if not whole:
        return {}
    return {
        name: Boundary.of({probe: not tally.breaking[name] for probe, tally in whole.items()}).describe()
        for name in experiment.criteria
    }
