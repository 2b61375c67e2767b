"""Reports of an experiment: files in a folder and tables in the terminal."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from passafe_services.tools.experiment.cells import displayed
from passafe_services.tools.experiment.kept_list import NAME as KEPT_LIST
from passafe_services.tools.experiment.kept_logs import KeptLog
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.schema import Experiment
from passafe_services.tools.experiment.summary import CellSummary, ExperimentSummary
from passafe_services.tools.experiment.tables import write_summary

MOST_ROWS: Final = 40
"""Most rows of a table in the terminal."""


def write_report(
    plan: Plan, summary: ExperimentSummary, kept: Sequence[KeptLog], agreement: Sequence[Agreement], folder: Path
) -> None:
    """Write tables, summary, page and, where an axis was bisected, the picture of its boundaries."""
    from passafe_dashboard.experiment_report import write_experiment_report  # noqa: PLC0415 - a second to import

    write_summary(plan, summary, agreement, folder)
    write_experiment_report(plan, summary, kept, agreement, folder)


def is_reported(folder: Path) -> bool:
    """Return whether the report in a folder is newer than its results and logs: nothing would change it."""
    sources = (folder / "results.jsonl", folder / KEPT_LIST)
    try:
        written_ns = (folder / "report.html").stat().st_mtime_ns
        return all(not source.exists() or source.stat().st_mtime_ns <= written_ns for source in sources)
    except OSError:  # there is none
        return False


def show(summary: ExperimentSummary, experiment: Experiment, console: Console) -> None:
    """Print a row for every cell: its boundaries if an axis was bisected, else the shares that break a criterion."""
    title = f"{experiment.title}: {summary.runs} runs"
    names = list(experiment.criteria)
    if summary.boundaries:
        table = _table(title, "variant", *summary.values, *names)
        for found in summary.boundaries[:MOST_ROWS]:
            texts = [found.boundaries[name].describe() for name in names]
            table.add_row(found.cell.variant, *map(displayed, found.cell.values.values()), *texts)
        left_out = len(summary.boundaries) - MOST_ROWS
    else:
        worst = experiment.worst.metric
        columns = "runs", *(f"break {name}" for name in names), "break verdict", f"worst {worst}\n(seed)"
        table = _table(title, "variant", *summary.values, *columns)
        for cell in summary.cells[:MOST_ROWS]:
            table.add_row(*_cells_of(cell, experiment))
        left_out = len(summary.cells) - MOST_ROWS
    console.print(table)
    if left_out > 0:
        console.print(f"{left_out} more rows in the tables")
    if summary.errors:
        console.print(f"[bold red]{summary.errors} runs could not be run[/]: column error of runs.csv")


def show_kept(kept: Sequence[KeptLog], console: Console) -> None:
    """Print which logs were kept, and whether they are the same runs."""
    for log in kept:
        if log.differing:
            console.print(f"[bold red]{log.path} is another run[/]: {', '.join(log.differing)} differ")
    if kept:
        console.print(f"logs      {len(kept)} in {kept[0].path.parent}")


def _table(title: str, *headers: str) -> Table:
    """Return a table that never cuts a value off: where the terminal is narrow, it goes on in the next line."""
    table = Table(
        title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, collapse_padding=True, padding=(0, 1, 0, 0)
    )
    for header in headers:
        table.add_column(header, overflow="fold", no_wrap=header is headers[-1])
    return table


def _cells_of(cell: CellSummary, experiment: Experiment) -> list[str]:
    shares = [f"{share.kept} of {share.of}" if share.kept else "none" for share in cell.breaking.values()]
    spread = cell.metrics[experiment.worst.metric]
    largest_is_worst = experiment.worst.at_most is not None
    worst = "unknown" if spread is None else f"{spread.max if largest_is_worst else spread.min:.3g} ({cell.worst.seed})"
    return [cell.cell.variant, *map(displayed, cell.cell.values.values()), str(cell.runs), *shares, worst]
