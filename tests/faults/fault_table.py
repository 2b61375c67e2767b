"""The fault table: every fault against every process that it can hit, live, in seeded passes.

``python tests/faults/fault_table.py --passes 3 --write docs/faults.md``; a pass takes some eight minutes. Results are
kept in ``--out``, so that an interrupted campaign resumes with the pass that it was in.
"""

import json
import math
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Final

import typer
from fault_rows import Fault, ending, from_strangers, survived
from fault_runs import Result, one_pass
from timeline import STUMBLE_S

LONGEST_SAID: Final = 110
"""Characters of one line that the table repeats."""

HEAD: Final = """# Faults

Made by `make faults` from live demos with a page at 250 ticks a second (`notomista-cai-2020`, mode both): each fault in
each pass once, in an order and at moments that follow from the pass's seed. *To safe*: from the fault until no input of
the filter or no command counts any more. *To recover*: from the end of the fault until the robot is driven again for
good. *Drives on*: but for 0.2 s at most, since a demo shares its processors with its judge. The worst of all passes is
shown. Barriers, energy, input limits, certificates and consistency are judged by the review of every run's log, between
samples too.

Runs that go on are those of `passafe demo --restart`; what strangers send is tried with `--insecure`, without which
they are not let in at all ([security](security.md)). What ends a run is tried without `--restart`: its verdict is never
`holds`, its exit code never 0, and none of its processes is left.
"""


def main(
    passes: Annotated[int, typer.Option(help="Number of passes.")] = 3,
    seed: Annotated[int, typer.Option(help="Seed of the first pass.")] = 1,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("runs/faults"),
    only: Annotated[str, typer.Option(help="Only faults whose name contains this.")] = "",
    note: Annotated[str, typer.Option(help="What to say of the machine.")] = "",
    write: Annotated[Path | None, typer.Option(help="Markdown file for the table.")] = None,
) -> None:
    """Run the passes that have no results yet, and write the table."""
    out.mkdir(parents=True, exist_ok=True)
    results = []
    for number in range(seed, seed + passes):
        kept = out / f"pass-{number}.json"
        if only or not kept.exists():
            sys.stdout.write(f"pass {number}\n")
            found = one_pass(number, only)
            if not only:
                kept.write_text(json.dumps([asdict(result) for result in found], indent=1), encoding="utf-8")
        else:
            found = [Result(**values) for values in json.loads(kept.read_text(encoding="utf-8"))]
        results.append(found)
    text = table(results, note)
    sys.stdout.write(text)
    if write is not None:
        write.write_text(text, encoding="utf-8")
    raise typer.Exit(any(result.broken for found in results for result in found))


def table(results: Sequence[Sequence[Result]], note: str = "") -> str:
    """Return the page with the table of several passes: of each fault the worst times."""
    faults = (*survived(), *from_strangers(), *ending())
    every = [result for found in results for result in found]
    broken = sum(bool(result.broken) for result in every)
    h_min = min((result.h_min for result in every if result.h_min is not None), default=math.nan)
    lines = [
        HEAD,
        f"{len(results)} passes, {len(every)} faults injected, **{broken} broken promises**; smallest barrier value of",
        f"all runs {h_min:.2g}.",
        *([] if not note else ["", note]),
        "",
        "| fault | at | promised | to safe, s | to recover, s | what was said | broken |",
        "|---|---|---|---|---|---|---|",
    ]
    for fault in faults:
        own = [result for result in every if result.fault == fault.key]
        if own:
            lines.append(row(fault, own))
    return "\n".join(lines) + "\n"


def readable(said: str) -> str:
    """Return a line of a log or of a terminal without numbers of sessions, folders and columns."""
    folders = rf"{re.escape(tempfile.gettempdir())}/\S*/"
    for pattern, instead in ((r"\d{12,}", "…"), (folders, ""), (r"\s*\|\s*", ": "), (r"\s+", " ")):
        said = re.sub(pattern, instead, said)
    return said if len(said) <= LONGEST_SAID else f"{said[:LONGEST_SAID]}…"


def row(fault: Fault, own: Sequence[Result]) -> str:
    """Return the row of a fault."""
    lost = [result for result in own if result.lost]
    safe = max((result.to_safe_s for result in lost if result.to_safe_s is not None), default=None)
    recover = [result.to_recover_s for result in lost]
    if fault.exit_code is not None:
        times = ("–", "–")
    elif not lost or max(result.undriven_s for result in lost) <= STUMBLE_S:
        gap_s = max(result.undriven_s for result in own)
        times = (f"drove on, but for {gap_s:.2f} s" if gap_s else "drove on", "–")
    else:
        never = None in recover
        times = (f"{safe or 0.0:.2f}", "never" if never else f"{max(one for one in recover if one is not None):.2f}")
    story = "; ".join(dict.fromkeys(map(readable, max((result.story for result in own), key=len))))
    broken = "; ".join(dict.fromkeys(text for result in own for text in result.broken)) or "no"
    cells = (fault.name, fault.target, fault.promise, *times, story or "–", broken)
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    typer.run(main)
