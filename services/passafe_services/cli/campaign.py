"""``passafe campaign``: run adversarial rollouts by the thousand."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from passafe.decision import FALLBACKS, Status
from passafe_services.cli.check import warn_at_load
from passafe_services.cli.errors import OptionError
from passafe_services.cli.options import WorkersOption, writable_folder
from passafe_services.cli.robot_option import OwnRobotOption
from passafe_services.cli.sweep import exit_if_interrupted, workers_for
from passafe_services.cli.uncertain_campaign import uncertain_campaign
from passafe_services.loop.stop import Stop, stop_requests
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.campaign.campaign_job import CampaignJob, campaign_results
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.campaign.summary import CampaignSummary
from passafe_services.tools.runs.results_file import ResultsFile
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.uncertain.trials import all_trials


def campaign(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder for results and summaries.")],
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(metavar="SCENARIO", help="Shipped scenarios (`passafe scenarios`) or TOML files."),
    ] = None,
    generated: Annotated[
        bool, typer.Option("--generated", help="Run systems made from seeds instead of scenarios.")
    ] = False,
    uncertain: Annotated[
        bool, typer.Option("--uncertain", help="Run plants that are not their model instead of scenarios.")
    ] = False,
    rollouts: Annotated[
        int, typer.Option("--rollouts", "-n", metavar="N", min=1, max=1_000_000, help="Rollouts of each scenario.")
    ] = 100,
    first_seed: Annotated[
        int, typer.Option("--first-seed", metavar="N", min=0, help="Seed of the first rollout; the others follow.")
    ] = 0,
    duration: Annotated[
        float,
        typer.Option("--duration", "-d", metavar="SECONDS", min=0.01, max=3600.0, help="Plant time of each rollout."),
    ] = 10.0,
    workers: WorkersOption = 0,
    scalar: Annotated[
        bool, typer.Option("--scalar", help="Decide every tick by the scalar filter instead of in batches; slow.")
    ] = False,
    robot: OwnRobotOption = None,
) -> None:
    """Let adversaries drive a scenario from random safe starts, and report the worst rollout.

    Filter and plant run alone, without network and delay. Five adversary operators take turns: piecewise constant,
    chirp, bang-bang at the barrier, always against the tightest row, always against the tank. h is checked between
    samples too. A thousand rollouts advance as one batch; the filter's certificate judges each decision, and the scalar
    filter repeats those that it rejects. Results are written batch by batch, and the same command resumes after an
    interruption. Exits with 0 only if h and tank stayed at or above zero, every input within its limits and every
    answer certified or in a defined fallback.

    With `--generated`, plants, barriers, limits and operators are drawn from the seed, eight rollouts of each design;
    how long they last follows from the design's rate, and inputs are lost at times. The summary has a line for each
    family of plants. Wherever a fallback is entered, braking alone is rolled out for comparison.

    With `--uncertain`, plants are members of five sets (disturbance, mass, damping, noise, and some of each), behind
    three links up to 200 + 200 ms with loss, in two scenarios at 250 Hz, mode `safe`: with the model's rows alone, with
    rows for the sets, with a guard at the plant, and with both. The summary has a line for each combination.

    Example: `passafe campaign notomista-cai-2020 --rollouts 1000 --out runs/campaign`
    """
    seeds = range(first_seed, first_seed + rollouts)
    kinds = {"scenarios": scenarios, "--generated": generated, "--uncertain": uncertain}
    given = [name for name, is_given in kinds.items() if is_given]
    if len(given) != 1:
        raise OptionError("SCENARIO", " and ".join(given) or "none", "scenarios, or --generated, or --uncertain")
    if uncertain:
        uncertain_campaign(writable_folder(out), all_trials(), seeds, duration, workers)
    if generated:
        from passafe_services.cli.generated_campaign import generated_campaign  # noqa: PLC0415 - 0.3 s that others save

        generated_campaign(writable_folder(out), seeds, workers)
    _of_scenarios(scenarios or [], out, seeds, duration, workers, scalar=scalar, robot=robot)


def _of_scenarios(
    scenarios: list[str],
    out: Path,
    seeds: range,
    duration: float,
    workers: int,
    *,
    scalar: bool,
    robot: str | None,
) -> NoReturn:
    loaded = [load_scenario(name, robot=robot) for name in scenarios]
    for scenario in loaded:
        warn_at_load(scenario)  # refused before any worker starts
    folder = writable_folder(out)
    console = Console(highlight=False, soft_wrap=True)
    summaries = []
    lowest_h = TextColumn("h ≥ {task.fields[h]}")
    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), lowest_h, TimeRemainingColumn())
    with stop_requests(lifeline=False) as stop, bar:
        for scenario in loaded:
            file = campaign_results(folder / f"{scenario.name}.jsonl", scenario, duration)
            _run(CampaignJob.of(scenario, duration, scalar=scalar), file, seeds, workers, bar, stop)
            exit_if_interrupted(stop, len(file.results), folder, console)
            summary = CampaignSummary.of(scenario.name, [file.results[seed] for seed in seeds])
            (folder / f"{scenario.name}.summary.json").write_text(summary.model_dump_json(indent=2), encoding="utf-8")
            summaries.append(summary)
    show(summaries)
    raise typer.Exit(0 if all(summary.holds for summary in summaries) else 1)


def _run(
    job: CampaignJob,
    file: ResultsFile[int, RolloutResult],
    seeds: range,
    workers: int,
    bar: Progress,
    stop: Stop,
) -> None:
    """Run the rollouts that are missing, write their results, and display the progress."""
    known = [file.results[seed].h_min for seed in seeds if seed in file.results]
    missing = [seed for seed in seeds if seed not in file.results]
    lowest = min(known, default=float("inf"))
    task = bar.add_task(file.path.stem, total=len(seeds), completed=len(known), h=f"{lowest:.3g}")
    if not missing:
        return
    with workers_for(job, workers, len(missing)) as pool:
        size = job.batch_size(len(missing), pool.count)
        for batch in file.add(sweep(FixedPlan(missing), pool, lambda _: size, stop.is_requested)):
            lowest = min(lowest, *(result.h_min for result in batch))
            bar.update(task, advance=len(batch), h=f"{lowest:.3g}")


def show(summaries: list[CampaignSummary]) -> None:
    """Print the summaries side by side, a column for each scenario."""
    table = Table("", *(summary.scenario for summary in summaries), title="Worst of all rollouts", title_justify="left")
    rows: dict[str, Callable[[CampaignSummary], str]] = {
        "rollouts": lambda of: f"{of.rollouts}",
        "lowest h": lambda of: f"{of.worst['h_min'].value:.3g} (seed {of.worst['h_min'].seed})",
        "lowest tank, J": lambda of: f"{of.worst['tank_min_j'].value:.3g} (seed {of.worst['tank_min_j'].seed})",
        "beyond limits": lambda of: f"{max(of.worst['overreach'].value, 0.0):.3g}",
        "ticks": lambda of: f"{of.ticks}",
        **{status.name: _count_of(status.name) for status in (Status.RELAXED, Status.BACKUP, *FALLBACKS)},
        "without margin": lambda of: f"{of.between_samples_unproven}",
        "decided by the scalar filter": lambda of: f"{of.decided_scalar / of.ticks:.2%}",
        "holds": lambda of: "yes" if of.holds else "[bold red]NO[/]",
    }
    for name, cell_text in rows.items():
        table.add_row(name, *map(cell_text, summaries))
    Console().print(table)


def _count_of(status: str) -> Callable[[CampaignSummary], str]:
    return lambda of: f"{of.statuses.get(status, 0)} in {of.rollouts_with.get(status, 0)} rollouts"
