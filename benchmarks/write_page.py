"""Runs the benchmarks one after the other and writes their ratios to a page: ``python benchmarks/write_page.py``.

Each runs in a process of its own, and its ratios are of quantities measured in turn there: ratios can be compared
between machines and days, times cannot. Exits with 1 if a check of a benchmark failed; the page then stays as it
was.
"""

import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from report import Ratio
from rich.console import Console

FOLDER: Final = Path(__file__).resolve().parent
PAGE: Final = FOLDER.parent / "docs" / "benchmarks.md"

BENCHMARKS: Final = {
    "filter_step": "one filter step beside other libraries, all of them solving the same program, answers compared",
    "filter_rows": "one filter step with 20 rows",
    "uncertain_step": "one filter step with rows for sets beside one for the model alone",
    "gatekeeper_step": "one filter step with a gatekeeper, rollouts interpreted and as machine code, answers compared",
    "prediction_cost": "prediction in a filter step, for a plant that is its model and for one that is not",
    "lockstep_speed": "one period of the loop in virtual time, CPU time",
    "replay_speed": "the replay of a log beside the loop that it repeats, processor time",
    "experiment_speed": "a sweep over bad networks",
    "campaign_speed": "one tick of an adversarial campaign, CPU time",
    "human_input": "errors of estimates of the operator's input and its rate, RMS of φ; least and most over signals",
    "log_rate": "a message on the recorder's way to the disk, processor time",
    "live_latency": "the path from operator to plant in a live system, play-out time included, median",
    "live_page": "the filter's loop beside ten pages that watch, beside none, by turns, median",
    "live_tls": "one way from filter to plant with TLS and access control, beside one without, by turns, median",
}
"""Benchmarks that measure ratios, with what they are of."""

PACKAGES: Final = (
    "passafe",
    "casadi",
    "piqp",
    "daqp",
    "numpy",
    "scipy",
    "msgspec",
    "cbfpy",
    "elastiqp",
    "jax",
    "cvxpy",
)

INTRODUCTION: Final = """# Benchmarks

`make bench` writes this page. Each ratio is of two quantities measured in turn in one process: median over rounds,
least and most. Ratios can be compared between machines and days; times cannot. Tests run every benchmark at its
smallest size, agreement checks included.
"""


def main(
    smallest: Annotated[bool, typer.Option("--smallest", help="Measure next to nothing.")] = False,
    page: Annotated[Path, typer.Option(help="File to write.")] = PAGE,
) -> None:
    """Run every benchmark that measures ratios, and write the page."""
    console = Console()
    reports: dict[str, dict[str, Any]] = {}
    failed, load = False, os.getloadavg()[0]
    for name in BENCHMARKS:
        console.print(f"{name} …", highlight=False)
        command = [sys.executable, str(FOLDER / f"{name}.py"), "--json", *(["--smallest"] if smallest else [])]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)  # noqa: S603 - ours
        if done.returncode:
            console.print(done.stdout, markup=False)
            failed = True
            continue
        reports[name] = json.loads(done.stdout)
    if failed:
        raise typer.Exit(1)
    page.write_text("\n".join(lines(reports, load)) + "\n", encoding="utf-8")
    console.print(f"{page}: written")


def lines(reports: dict[str, dict[str, Any]], load: float) -> Iterator[str]:
    """Yield the lines of the page; the load is that of the machine before the first benchmark."""
    yield INTRODUCTION
    yield "| benchmark | dividend | divisor | ratio | least to most |"
    yield "|---|---|---|---|---|"
    for name, report in reports.items():
        for ratio in (Ratio(**each) for each in report["ratios"]):
            spread = "" if ratio.least == ratio.most else f"{ratio.least:.2f} to {ratio.most:.2f}"
            yield f"| `{name}` | {ratio.of} | {ratio.over} | {ratio.median:.2f} | {spread} |"
    yield ""
    yield f"Measured {datetime.now(UTC):%Y-%m-%d} on {processor()}, {os.cpu_count()} processors, load {load:.1f}"
    yield f"before, {platform.system()}, Python {platform.python_version()}, {', '.join(versions())}."
    for name, report in reports.items():
        yield f"\n## {name}\n\n`python benchmarks/{name}.py`: {BENCHMARKS[name]}. {report['title']}.\n"
        columns = report["columns"]
        yield from (f"| {' | '.join(cells)} |" for cells in [columns, ["---"] * len(columns), *report["rows"]])
        if report["notes"]:
            yield ""
        yield from (f"- {note}" for note in report["notes"])


def versions() -> Iterator[str]:
    """Yield name and version of the installed packages that matter."""
    for name in PACKAGES:
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            continue


def processor() -> str:
    """Return the processor's name where the system reports it."""
    info = Path("/proc/cpuinfo")
    text = info.read_text(encoding="utf-8") if info.exists() else ""
    names = [line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")]
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    typer.run(main)
