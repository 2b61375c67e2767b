"""``passafe replay``: step a logged run's filter again."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from passafe_services.tools.replay import replay_filter
from passafe_services.tools.review.run_log import RunLog


def replay(run: Annotated[Path, typer.Argument(help="MCAP log of a run, live or simulated.")]) -> None:
    """Step the filter again with what it consumed in the run and compare every tick to the last bit.

    Exits with 0 only if all ticks are the same: then the log holds everything that decided what the filter did.
    """
    result = replay_filter(RunLog.read(run))
    console = Console(highlight=False)
    console.print(f"{result.identical} of {result.ticks} ticks identical")
    if result.missing:
        console.print(f"stopped there: {result.missing} messages that the next tick consumed are not in the log")
    if result.first_difference:
        console.print(f"first difference: {result.first_difference}")
    raise typer.Exit(0 if result.exact else 1)
