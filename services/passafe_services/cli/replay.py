"""``passafe replay``: repeat the filter's decisions of a log."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from passafe_services.cli.log_progress import log_progress
from passafe_services.tools.replay.replay_log import replay_file


def replay(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="LOG|FOLDER",
            help="MCAP log of a run, live or simulated: its first file, or a folder of one recording.",
        ),
    ],
) -> None:
    """Replay the filter on the inputs that it consumed in a run, and compare every tick to the last bit.

    The log is all that it takes, on any machine: no scenario file, none of the run's other files. Where a tick differs,
    its first fields that do are named with both values, and so are versions that are not those of the log.

    Exits with 0 only if all ticks are identical: then the log holds everything that the filter's decisions depend on.

    Example: `passafe replay runs/bad.mcap`
    """
    with log_progress("replaying") as show:
        result = replay_file(run, progress=show)
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"{result.identical} of {result.ticks} ticks identical")
    if result.missing:
        console.print(f"stopped there: {result.missing} messages that the next tick consumed are not in the log")
    if result.first_difference:
        console.print(f"first difference, logged -> replayed: {escape(result.first_difference)}")
    if result.versions:
        pairs = ", ".join(f"{name} {logged} -> {own}" for name, (logged, own) in result.versions.items())
        console.print(f"versions differ, of the log -> here: {pairs}")
    raise typer.Exit(0 if result.exact else 1)
