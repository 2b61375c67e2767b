"""``passafe campaign --uncertain``: plants that are not their model, with and without rows for that."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from passafe_services.cli.sweep import exit_if_interrupted, workers_for
from passafe_services.loop.stop import stop_requests
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.uncertain.summary import TrialSummary, UncertainSummary
from passafe_services.tools.uncertain.trials import UncertainTrial
from passafe_services.tools.uncertain.uncertain_job import UncertainJob, uncertain_results


def uncertain_campaign(
    folder: Path, cells: Sequence[UncertainTrial], seeds: range, duration_s: float, workers: int
) -> NoReturn:
    """Run the rollouts that are missing, write their results and the summary, and end the command.

    Args:
        folder: For results and summary.
        cells: What is run.
        seeds: Of each cell's rollouts.
        duration_s: Plant time of each rollout, s.
        workers: Number of processes; 0: one for each processor.
    """
    console = Console(highlight=False, soft_wrap=True)
    summaries = []
    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with stop_requests(lifeline=False) as stop, bar:
        task = bar.add_task("uncertain", total=len(seeds) * len(cells))
        for cell in cells:
            job = UncertainJob(cell=cell, duration_s=duration_s)
            file = uncertain_results(folder, job)
            missing = [seed for seed in seeds if seed not in file.results]
            bar.update(task, advance=len(seeds) - len(missing), description=cell.name)
            if missing:
                with workers_for(job, workers, len(missing)) as pool:
                    size = job.batch_size(len(missing), pool.count)
                    for batch in file.add(sweep(FixedPlan(missing), pool, partial(_constant, size), stop.is_requested)):
                        bar.update(task, advance=len(batch))
            exit_if_interrupted(stop, len(file.results), folder, console)
            summaries.append(TrialSummary.of(cell, [file.results[seed] for seed in seeds]))
    summary = UncertainSummary(cells=tuple(summaries))
    (folder / "uncertain.summary.json").write_text(summary.model_dump_json(indent=2), encoding="utf-8")
    show(summary, console)
    raise typer.Exit(0 if summary.holds else 1)


def show(summary: UncertainSummary, console: Console) -> None:
    """Print a line for each cell."""
    columns: dict[str, Callable[[TrialSummary], str]] = {
        "scenario": lambda of: of.scenario,
        "sets": lambda of: of.sets,
        "link, ms": lambda of: of.link,
        "protection": lambda of: of.protection,
        "h ≥ 0": lambda of: f"{of.safe}/{of.rollouts}",
        "worst h": lambda of: f"{of.h_worst:.2g} (seed {of.worst_seed})",
        "stands off, mm": lambda of: f"{1000 * of.stand_off_m:.1f}",
        "guard acts": lambda of: f"{of.guarded_share:.1%}",
        "fallback": lambda of: f"{of.fallback_share:.2%}",
        "holds": lambda of: ("yes" if of.holds else "[bold red]NO[/]") if of.is_promised else "",
    }
    table = Table(*columns, title="Plants that are not their model", title_justify="left", box=None)
    for cell in summary.cells:
        table.add_row(*(text(cell) for text in columns.values()))
    console.print(table)


def _constant(size: int, _left: int) -> int:
    return size
