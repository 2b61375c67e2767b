"""``passafe replay``: repeat the filter's decisions of a log."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from passafe_services.tools.replay import replay_filter
from passafe_services.tools.review.run_log import RunLog


def replay(run: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log of a run, live or simulated.")]) -> None:
    """Replay the filter on the inputs that it consumed in a run, and compare every tick to the last bit.

    Exits with 0 only if all ticks are identical: then the log holds everything that the filter's decisions depend on.

    Example: `passafe replay runs/bad.mcap`
    """
    result = replay_filter(RunLog.read(run))
    console = Console(highlight=False)
    console.print(f"{result.identical} of {result.ticks} ticks identical")
    if result.missing:
        console.print(f"stopped there: {result.missing} messages that the next tick consumed are not in the log")
    if result.first_difference:
        console.print(f"first difference: {result.first_difference}")
    raise typer.Exit(0 if result.exact else 1)
