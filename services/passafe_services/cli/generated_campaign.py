"""``passafe campaign --generated``: closed loops of systems made from seeds."""

from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from passafe_services.cli.sweep import exit_if_interrupted, workers_for
from passafe_services.loop.stop import stop_requests
from passafe_services.tools.generated.generated_job import GeneratedJob, generated_results
from passafe_services.tools.generated.summary import FamilySummary, GeneratedSummary
from passafe_services.tools.runs.sweep import FixedPlan, sweep


def generated_campaign(folder: Path, seeds: range, workers: int) -> NoReturn:
    """Run the loops that are missing, write their results and the summary, and end the command.

    Args:
        folder: For results and summary.
        seeds: Of the loops.
        workers: Number of processes; 0: one for each processor.
    """
    console = Console(highlight=False, soft_wrap=True)
    file = generated_results(folder / "generated.jsonl")
    missing = [seed for seed in seeds if seed not in file.results]
    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with stop_requests(lifeline=False) as stop, bar:
        task = bar.add_task("generated", total=len(seeds), completed=len(seeds) - len(missing))
        if missing:
            job = GeneratedJob()
            with workers_for(job, workers, len(missing)) as pool:
                size = job.chunk_size(len(missing), pool.count)
                for chunk in file.add(sweep(FixedPlan(missing), pool, lambda _: size, stop.is_requested)):
                    bar.update(task, advance=len(chunk))
        exit_if_interrupted(stop, len(file.results), folder, console)
    summary = GeneratedSummary.of([file.results[seed] for seed in seeds])
    (folder / "generated.summary.json").write_text(summary.model_dump_json(indent=2), encoding="utf-8")
    show(summary, console)
    raise typer.Exit(0 if summary.holds else 1)


def show(summary: GeneratedSummary, console: Console) -> None:
    """Print a line for each family, and the seeds of what went wrong."""
    columns: dict[str, Callable[[FamilySummary], str]] = {
        "family": lambda of: of.family,
        "loops": lambda of: f"{of.loops}",
        "h ≥ 0": lambda of: f"{of.safe}/{of.counted}",
        "worst h": lambda of: f"{of.h_worst:.2g}",
        "tank": lambda of: "" if of.tank_worst is None else f"{of.tank_worst:.2g}",
        "fallback": lambda of: f"{of.fallback_share:.2%}",
        "accepted": lambda of: f"{of.feasible_accepted}/{of.feasible}",
        "holds": lambda of: "yes" if of.holds else "[bold red]NO[/]",
    }
    title = "Loops of accepted designs that started in the protected set; accepted of those with a feasible oracle"
    table = Table(*columns, title=title, title_justify="left", box=None)
    for family in summary.families:
        table.add_row(*(text(family) for text in columns.values()))
    console.print(table)
    for family in summary.families:
        kinds = {
            "h < 0": family.unsafe_seeds,
            "tank < 0": family.insolvent_seeds,
            "beyond limits": family.beyond_limits_seeds,
            "braking better": family.braking_better_seeds,
        }
        for kind, seeds in kinds.items():
            if seeds:
                console.print(f"{family.family}, {kind}: seeds {', '.join(map(str, seeds))}")
    console.print(
        f"accepted of the designs with a feasible oracle: {summary.accepted_share:.1%}; "
        f"{summary.as_drawn_share:.1%} as drawn, the others with the gatekeeper that the check advises"
    )
