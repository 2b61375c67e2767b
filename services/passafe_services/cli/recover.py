"""``passafe recover``: write a whole log from one whose writer was killed."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from passafe_services.tools.recover import recover


def recover_log(
    torn: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log whose writer was killed.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="MCAP log to write; must not exist yet.")],
) -> None:
    """Copy all readable messages of a torn log to a new, whole one.

    Example: `passafe recover runs/torn.mcap --out runs/whole.mcap`
    """
    kept = recover(torn, out)
    console = Console()
    console.print(f"kept {kept.messages} messages over {kept.duration_s:.3f} s", highlight=False)
    for channel, count in sorted(kept.channels.items()):
        console.print(f"  {channel:<28} {count}", highlight=False)
    console.print("the log was whole" if kept.was_finished else f"it ends with: {kept.tear}", highlight=False)
    console.print(f"log       {out}", highlight=False, soft_wrap=True)
