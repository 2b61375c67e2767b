"""``passafe recover``: write a whole log from one that is torn or damaged."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from passafe_services.cli.log_time import log_time
from passafe_services.tools.recover import recover
from passafe_services.tools.recovered_copy import Loss


def recover_log(
    torn: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log that is torn or damaged.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="MCAP log to write; must not exist yet.")],
) -> None:
    """Copy everything intact in a torn or damaged log, before and after the damage, to a new, whole log.

    Says what is lost: the bytes, the time, and the sequence numbers of each topic.

    Example: `passafe recover runs/torn.mcap --out runs/whole.mcap`
    """
    kept = recover(torn, out)
    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.print(f"kept {kept.messages} messages over {kept.duration_s:.3f} s")
    for channel, count in sorted(kept.channels.items()):
        console.print(f"  {channel:<28} {count}")
    for loss in kept.losses:
        console.print(f"lost      {_in_words(loss)}")
        for channel, (first, last) in sorted(loss.missing.items()):
            console.print(f"  {channel:<28} {first} to {last}, {last - first + 1} messages")
    if kept.orphans:
        console.print(f"left out  {kept.orphans} messages of which no intact record says what they are")
    if kept.altered:
        console.print(f"altered   metadata records that are not as they were written: {', '.join(kept.altered)}")
    console.print("the log was whole" if kept.was_finished else kept.tear)
    console.print(f"log       {out}")


def _in_words(loss: Loss) -> str:
    """Return where a loss is: its bytes, the times that a damaged chunk claims, those of the messages around it."""
    damage = loss.damage
    said = [str(damage)]
    if damage.first_ns is not None and damage.last_ns is not None:
        said.append(f"by its own head {log_time(damage.first_ns)} to {log_time(damage.last_ns)}")
    after = "the beginning" if loss.after_ns is None else log_time(loss.after_ns)
    before = "the end" if loss.before_ns is None else log_time(loss.before_ns)
    said.append(f"between {after} and {before}")
    return "; ".join(said)
