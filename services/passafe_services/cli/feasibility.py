"""``passafe feasibility``: where the filter's duties can be kept at all."""

import re
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Final

import casadi as ca
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from passafe.models.robot import Robot
from passafe.workspace import Array
from passafe_services.cli.errors import OptionError
from passafe_services.cli.options import DEFAULT_SCENARIO, ScenarioOption, writable_folder
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.feasibility.atlas import WHAT_IT_SAYS, Atlas, AtlasSummary, SampleSummary
from passafe_services.tools.feasibility.constraint_feasibility import ConstraintFeasibility, Findings
from passafe_services.tools.feasibility.errors import FeasibilityError
from passafe_services.tools.feasibility.grid import MOST_CELLS, Grid, GridCoordinate
from passafe_services.tools.feasibility.share import Share, random_states

EITHER_SIDE: Final = 3.0
"""The box of a scenario that gives none: ±3 in every coordinate, as for campaigns."""

_COORDINATE: Final = re.compile(r"x(\d{1,3})")


def feasibility(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for CSV, picture and summary.")],
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    axes: Annotated[str, typer.Option("--axes", help="Two coordinates of the state to vary; x0 is the first.")] = (
        "x0,x1"
    ),
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="NAME=VALUE", help="Value of another coordinate, instead of the scenario's x0."),
    ] = None,
    limits: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="LOW,HIGH", help="Of both axes; given twice: of the first, of the second."),
    ] = None,
    cells: Annotated[int, typer.Option("--cells", min=1, max=MOST_CELLS, help="Cells along each axis.")] = 100,
    at: Annotated[float, typer.Option("--at", help="Plant time, s, where barriers move.")] = 0.0,
    gain: Annotated[
        float | None,
        typer.Option("--gain", help="Gain of every barrier's class-K functions, instead of the scenario's."),
    ] = None,
    samples: Annotated[int, typer.Option("--samples", "-n", min=0, help="Random states beside the map.")] = 10_000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random states.")] = 1,
    low: Annotated[str | None, typer.Option("--low", help="Least corner of their box: one number, or n.")] = None,
    high: Annotated[str | None, typer.Option("--high", help="Largest corner, likewise.")] = None,
) -> None:
    """Map where the filter's duties can be kept, under the scenario's limits.

    Asks three questions of every cell of a slice of the state space: is the state in the set that the rows protect;
    does an input within magnitude and norm limits keep the hard rows; does one keep passivity too, without slack (a
    tank at its initial level). Random states tell which share of the protected set that is. Limits of the rate are
    left out, because the input before is not known. Each state is judged by itself: that its rows can be kept does
    not say that those of the states it leads to can.

    Example: `passafe feasibility --fix x2=-1 --fix x3=-1 --range -3,3 --gain 1 --out runs/atlas`
    """
    loaded = _with_gain(load_scenario(scenario), gain)
    robot = robot_of(loaded)
    grid = _grid(loaded, axes, fix or [], limits or [], cells)
    box = _box(loaded, low, high)
    if not isfinite(at):
        raise OptionError("--at", at, "a finite number, s")
    keeping = ConstraintFeasibility(design_of(loaded, robot), at)
    folder = writable_folder(out)
    drawn = random_states(*box, samples, seed)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        found = _searched(keeping, grid.states(), bar, "cells")
        sampled = _searched(keeping, drawn, bar, "random states") if samples else None
    atlas = Atlas(scenario=loaded.name, grid=grid, plant_time_s=at, found=found)
    summary = atlas.summary(None if sampled is None else SampleSummary.of(sampled, *box, seed))
    written = _write(atlas, summary, robot, folder)
    _show(summary)
    typer.echo("wrote " + ", ".join(str(path) for path in written))


def _searched(keeping: ConstraintFeasibility, states: Array, bar: Progress, name: str) -> Findings:
    task = bar.add_task(name, total=states.shape[1])
    parts = []
    for part in keeping.piecewise(states):
        parts.append(part)
        bar.update(task, advance=part.states.shape[1])
    return Findings.joined(parts)


def _grid(scenario: Scenario, axes: str, fix: Sequence[str], ranges: Sequence[str], cells: int) -> Grid:
    n = len(scenario.plant.x0)
    names = axes.split(",")
    if len(names) != len(("across", "up")):
        raise OptionError("--axes", repr(axes), "two coordinates such as x0,x1")
    across, up = (_coordinate("--axes", name, n) for name in names)
    fixed = list(scenario.plant.x0)
    for text in fix:
        name, equals, value = text.partition("=")
        if not equals:
            raise OptionError("--fix", repr(text), "NAME=VALUE such as x2=-0.5")
        index = _coordinate("--fix", name, n)
        if index in {across, up}:
            raise OptionError("--fix", repr(text), f"a coordinate other than those of --axes, {axes}")
        [fixed[index]] = _numbers("--fix", value, (1,))
    both = [_numbers("--range", text, (2,)) for text in ranges]
    if len(both) > len(names):
        raise OptionError("--range", f"{len(both)} of them", "one for both axes, or one for each")
    box = tuple(zip(*_box(scenario, None, None), strict=True))
    first, second = (both * 2)[:2] if both else (box[across], box[up])
    try:
        return Grid(
            across=GridCoordinate(index=across, low=first[0], high=first[1]),
            up=GridCoordinate(index=up, low=second[0], high=second[1]),
            fixed=tuple(fixed),
            cells=cells,
        )
    except FeasibilityError as error:
        option = "--range" if error.field.startswith("range") else "--axes"
        raise OptionError(option, error.got, error.allowed) from error


def _box(scenario: Scenario, low: str | None, high: str | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
    n = len(scenario.plant.x0)
    lowest = scenario.plant.start_low or (-EITHER_SIDE,) * n
    highest = scenario.plant.start_high or (EITHER_SIDE,) * n
    lowest = lowest if low is None else _corner("--low", low, n)
    highest = highest if high is None else _corner("--high", high, n)
    for each, other in zip(lowest, highest, strict=True):
        if not each <= other:
            raise OptionError("--low, --high", f"{each:g} above {other:g}", "a box with room in it")
    return lowest, highest


def _corner(option: str, text: str, n: int) -> tuple[float, ...]:
    numbers = _numbers(option, text, (1, n))
    return numbers * n if len(numbers) == 1 else numbers


def _numbers(option: str, text: str, lengths: Sequence[int]) -> tuple[float, ...]:
    wanted = f"{' or '.join(map(str, lengths))} finite numbers, with commas between them"
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise OptionError(option, repr(text), wanted) from error
    if len(numbers) not in lengths or not all(map(isfinite, numbers)):
        raise OptionError(option, repr(text), wanted)
    return numbers


def _coordinate(option: str, name: str, n: int) -> int:
    match = _COORDINATE.fullmatch(name.strip())
    if match is None or int(match[1]) >= n:
        raise OptionError(option, repr(name), f"x0 to x{n - 1}, the states of the model")
    return int(match[1])


def _with_gain(scenario: Scenario, gain: float | None) -> Scenario:
    if gain is None:
        return scenario
    if not 0.0 < gain <= 1e6:  # noqa: PLR2004 - the range of a gain in a scenario file
        raise OptionError("--gain", gain, "above 0, up to 1e6")
    barriers = []
    for barrier in scenario.filter.barriers:
        chain = tuple(each.model_copy(update={"gain": gain}) for each in barrier.class_k)
        barriers.append(barrier.model_copy(update={"class_k": chain}))
    return scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"barriers": tuple(barriers)})})


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
    """Print what the map came to."""
    title = f"{summary.scenario}: what can be kept"
    table = Table("", "cells of the map", "random states (95 %)", title=title, title_justify="left")
    counts, sample = summary.slice, summary.sample
    rows = (
        ("in the protected set", counts.inside, counts.states, sample and sample.inside),
        ("of these: hard rows kept", counts.hard, counts.inside, sample and sample.hard),
        ("of these: passivity too", counts.passive, counts.inside, sample and sample.passive),
    )
    for name, kept, of, share in rows:
        table.add_row(name, _percent(kept, of), _with_interval(share) if share else "–")
    console = Console()
    console.print(table)
    console.print(WHAT_IT_SAYS)
    unsettled = counts.unsettled + (sample.counts.unsettled if sample else 0)
    if unsettled:
        console.print(f"At {unsettled} of all these states a larger margin may exist than was found.")


def _percent(kept: int, of: int) -> str:
    return f"{kept} of {of}" + (f" ({100 * kept / of:.2f} %)" if of else "")


def _with_interval(share: Share) -> str:
    if not share.of:
        return "–"
    return f"{share.kept} of {share.of} ({100 * share.low:.4g} to {100 * share.high:.4g} %)"
