"""``passafe feasibility``: map where the filter's constraints can be met."""

from math import isfinite
from pathlib import Path
from typing import Annotated

import casadi as ca
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from passafe.models.robot import Robot
from passafe.numerics.workspace import Array
from passafe_services.cli.errors import OptionError
from passafe_services.cli.feasibility_options import box_of, grid_of, with_gain
from passafe_services.cli.options import DEFAULT_SCENARIO, ScenarioOption, writable_folder
from passafe_services.cli.robot_option import OwnRobotOption
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.feasibility.atlas import LIMITATION, Atlas, AtlasSummary, SampleSummary
from passafe_services.tools.feasibility.constraint_feasibility import ConstraintFeasibility, Findings
from passafe_services.tools.feasibility.grid import MOST_CELLS
from passafe_services.tools.feasibility.share import Share, random_states


def feasibility(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder for CSV, picture and summary.")],
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    robot: OwnRobotOption = None,
    axes: Annotated[
        str, typer.Option("--axes", metavar="NAME,NAME", help="Two coordinates of the state to vary; x0 is the first.")
    ] = ("x0,x1"),
    fix: Annotated[
        list[str] | None,
        typer.Option(
            "--fix",
            metavar="NAME=VALUE",
            help="Value of another coordinate, instead of that in the scenario's x0; repeat for others.",
        ),
    ] = None,
    limits: Annotated[
        list[str] | None,
        typer.Option(
            "--range", metavar="LOW,HIGH", help="Range of both axes; given twice, that of the first and of the second."
        ),
    ] = None,
    cells: Annotated[
        int, typer.Option("--cells", metavar="N", min=1, max=MOST_CELLS, help="Cells along each axis.")
    ] = 100,
    at: Annotated[float, typer.Option("--at", metavar="SECONDS", help="Plant time, for barriers that move.")] = 0.0,
    gain: Annotated[
        float | None,
        typer.Option(
            "--gain", metavar="GAIN", help="Gain of every barrier's class-K functions, instead of the scenario's."
        ),
    ] = None,
    samples: Annotated[
        int, typer.Option("--samples", "-n", metavar="N", min=0, help="Number of random states.")
    ] = 10_000,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the random states.")] = 1,
    low: Annotated[
        str | None,
        typer.Option(
            "--low",
            metavar="NUMBERS",
            help="Least corner of the box of random states: one number for all coordinates, or one for each.",
        ),
    ] = None,
    high: Annotated[
        str | None, typer.Option("--high", metavar="NUMBERS", help="Largest corner of that box, likewise.")
    ] = None,
) -> None:
    """Map where the filter's constraints can be met, within the scenario's limits of the input.

    Each cell of a slice of the state space answers three questions: is the state in the set that the rows protect;
    does an input within the magnitude and norm limits satisfy the hard rows; does one satisfy the passivity row too,
    without slack (with the tank at its initial level). Random states estimate the same shares of the whole protected
    set. Rate limits are left out, since the previous input is not known. Each state is judged by itself: that its
    rows can be satisfied does not imply that those of its successors can.

    Example: `passafe feasibility --fix x2=-1 --fix x3=-1 --range -3,3 --gain 1 --out runs/atlas`
    """
    loaded = with_gain(load_scenario(scenario, robot=robot), gain)
    model = robot_of(loaded)
    grid = grid_of(loaded, axes, fix or [], limits or [], cells)
    box = box_of(loaded, low, high)
    if not isfinite(at):
        raise OptionError("--at", at, "a finite number, s")
    keeping = ConstraintFeasibility(design_of(loaded, model), at)
    folder = writable_folder(out)
    drawn = random_states(*box, samples, seed)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        found = _searched(keeping, grid.states(), bar, "cells")
        sampled = _searched(keeping, drawn, bar, "random states") if samples else None
    atlas = Atlas(scenario=loaded.name, grid=grid, plant_time_s=at, found=found)
    summary = atlas.summary(None if sampled is None else SampleSummary.of(sampled, *box, seed))
    written = _write(atlas, summary, model, folder)
    _show(summary)
    typer.echo("wrote " + ", ".join(str(path) for path in written))


def _searched(keeping: ConstraintFeasibility, states: Array, bar: Progress, name: str) -> Findings:
    task = bar.add_task(name, total=states.shape[1])
    parts = []
    for part in keeping.piecewise(states):
        parts.append(part)
        bar.update(task, advance=part.states.shape[1])
    return Findings.joined(parts)


def _write(atlas: Atlas, summary: AtlasSummary, robot: Robot, folder: Path) -> list[Path]:
    from passafe_dashboard.feasibility_picture import atlas_picture  # noqa: PLC0415 - a second that a refusal need not wait

    table, drawing, sums = (folder / f"{atlas.scenario}.{kind}" for kind in ("csv", "svg", "summary.json"))
    with table.open("w", encoding="utf-8", newline="") as file:
        atlas.write_csv(file)
    kinds = [_kind(robot, axis.index) for axis in (atlas.grid.across, atlas.grid.up)]
    across, up = (
        f"x{axis.index} ({kind})" for axis, kind in zip((atlas.grid.across, atlas.grid.up), kinds, strict=True)
    )
    svg = atlas_picture(atlas, across=across, up=up, same_scale=kinds[0] == kinds[1])
    drawing.write_text(svg, encoding="utf-8")
    sums.write_text(summary.model_dump_json(indent=2), encoding="utf-8")
    return [table, drawing, sums]


def _kind(robot: Robot, index: int) -> str:
    symbol = robot.system.x[index]
    for kind, expression in (("position", robot.position), ("velocity", robot.velocity)):
        if ca.depends_on(expression, symbol):
            return kind
    return "state"


def _show(summary: AtlasSummary) -> None:
    """Print the counts of the map and the shares of the random states."""
    title = f"{summary.scenario}: constraints that can be met"
    table = Table("", "cells of the map", "random states (95 %)", title=title, title_justify="left")
    counts, sample = summary.slice, summary.sample
    rows = (
        ("in the protected set", counts.inside, counts.states, sample and sample.inside),
        ("of these: hard rows feasible", counts.hard, counts.inside, sample and sample.hard),
        ("of these: passivity feasible too", counts.passive, counts.inside, sample and sample.passive),
    )
    for name, kept, of, share in rows:
        table.add_row(name, _percent(kept, of), _with_interval(share) if share else "–")
    console = Console()
    console.print(table)
    console.print(LIMITATION)
    unsettled = counts.unsettled + (sample.counts.unsettled if sample else 0)
    if unsettled:
        console.print(f"At {unsettled} of all these states a larger margin may exist than was found.")


def _percent(kept: int, of: int) -> str:
    return f"{kept} of {of}" + (f" ({100 * kept / of:.2f} %)" if of else "")


def _with_interval(share: Share) -> str:
    if not share.of:
        return "–"
    return f"{share.kept} of {share.of} ({100 * share.low:.4g} to {100 * share.high:.4g} %)"
