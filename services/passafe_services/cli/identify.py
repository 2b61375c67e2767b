"""``passafe identify``: estimate a robot from its logs."""

from itertools import chain
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from passafe_services.cli.options import writable_folder
from passafe_services.cli.output_files import require_separate
from passafe_services.log.log_files import files_of
from passafe_services.tools.identify.identification import LEFT_OUT, WINDOW_S, Identification, identify
from passafe_services.tools.identify.motion_log import motion_of

ParameterOption = Annotated[
    list[str] | None,
    typer.Option("--parameter", metavar="NAME", help="Parameter to estimate; all of the model if not given."),
]


def identify_robot(
    runs: Annotated[list[Path], typer.Argument(metavar="LOG…", help="MCAP logs of one robot at one rate.")],
    parameter: ParameterOption = None,
    window: Annotated[
        float, typer.Option(min=0.02, max=10.0, help="Window in which a disturbance may count as constant, s.")
    ] = WINDOW_S,
    left_out: Annotated[
        float, typer.Option(min=0.0, max=0.1, help="Share of the states that the sets need not explain.")
    ] = LEFT_OUT,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the scenario lines here.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Estimate parameters, noise and the smallest sets that explain logs, and print them as scenario lines.

    Parameters and noise come from a fit of the model to windows of the motion, each with a state and a constant
    disturbance of its own. The sets are those with which all states but a share agree with the ones before them.
    Drive with changing inputs: a robot that stands tells nothing of its mass.

    Examples:
    - `passafe identify runs/drive.mcap`
    - `passafe identify monday.mcap tuesday.mcap --parameter mass --out sets.toml`
    """
    require_separate({"--out": out}, chain.from_iterable(map(files_of, runs)))
    if out is not None:
        writable_folder(out.parent)
    found = identify(motion_of(runs), parameter or (), window_s=window, left_out=left_out)
    if out is not None:
        out.write_text(found.scenario_lines(), encoding="utf-8")
    if json:
        typer.echo(found.model_dump_json(indent=2))
        return
    print_identification(Console(highlight=False), found)
    if out is not None:
        typer.echo(f"written   {out}")


def print_identification(console: Console, found: Identification) -> None:
    """Print an estimate: parameters, noise, what the sets leave out, and the scenario lines."""
    table = Table("parameter", "estimate", "standard error", "interval")
    for name, value in found.parameters.items():
        low, high = found.intervals[name]
        table.add_row(name, f"{value:.5g}", f"{found.errors[name]:.2g}", f"{low:g} to {high:g}")
    console.print(table)
    for name in found.unknown:
        console.print(f"{name}: the logs say too little of it, it keeps the model's value")
    noise = ", ".join(f"{value:.3g}" for value in found.noise)
    console.print(f"noise     standard deviation of each state {noise}")
    console.print(f"sets      leave out {100 * found.left_out:.2g} % of {found.samples} states")
    console.print(f"\n{found.scenario_lines()}", markup=False)
