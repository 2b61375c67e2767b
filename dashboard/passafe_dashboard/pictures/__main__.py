"""The paper's two plots of a run as one picture, and the README's four pictures by one command.

``python -m passafe_dashboard.pictures FOLDER`` runs the reference scenario live in each mode and draws its log;
``python -m passafe_dashboard.pictures FOLDER RUN.mcap …`` draws the logs given.
"""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog

from passafe_dashboard.charts.run_charts import run_charts
from passafe_dashboard.reports.run_page import descriptions
from passafe_dashboard.reports.run_series import RunSeries
from passafe_dashboard.run_report import series_of
from passafe_dashboard.svg.chart import Placed, picture

MODES: Final = ("off", "passive", "safe", "both")
DURATION_S: Final = 10
PLANE_SIDE: Final = 440.0
CHART_WIDTH: Final = 520.0
BINS: Final = 400
"""Enough for a chart 450 units wide; lowest and highest samples of each bin stay."""


def run_picture(series: RunSeries, *, title: str) -> str:
    """SVG of a run: its path in the plane, if it has one, beside h and power margin over time.

    Raises:
        UndrawableError: A chart has a part that SVG export does not know.
    """
    charts = run_charts(series, bins=BINS)
    over_time = [charts[name] for name in ("h", "power_margin") if name in charts]
    height = PLANE_SIDE / len(over_time)
    left = PLANE_SIDE if "plane" in charts else 0.0
    placed = [Placed(charts["plane"], 0, 0, PLANE_SIDE, PLANE_SIDE)] if "plane" in charts else []
    placed += [Placed(chart, left, number * height, CHART_WIDTH, height) for number, chart in enumerate(over_time)]
    texts = descriptions(series)
    return picture(
        placed,
        width=left + CHART_WIDTH,
        height=PLANE_SIDE,
        title=title,
        description=" ".join(texts[name] for name in ("plane", "h", "power_margin") if name in charts),
    )


def draw_log(path: Path, folder: Path) -> Path:
    """Draw a log into ``folder`` and return the picture's path: scenario-mode.svg."""
    log = RunLog.read(path)
    scenario = log.identity.scenario
    series = series_of(log, CoreEvaluator(scenario))
    title = f"{scenario.title}: mode {scenario.filter.mode}, law {scenario.filter.law}"
    target = folder / f"{scenario.name}-{scenario.filter.mode}.svg"
    target.write_text(run_picture(series, title=title), encoding="utf-8")
    return target


def main(arguments: Sequence[str]) -> int:
    """Draw pictures; returns the exit code."""
    if not arguments:
        sys.stderr.write("usage: python -m passafe_dashboard.pictures FOLDER [RUN.mcap …]\n")
        return 2
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as scratch:
        logs = [Path(name) for name in arguments[1:]] or [_run_live(mode, Path(scratch)) for mode in MODES]
        for log in logs:
            sys.stdout.write(f"{draw_log(log, folder)}\n")
    return 0


def _run_live(mode: str, scratch: Path) -> Path:
    """Log of a live run of the reference scenario."""
    folder = scratch / mode
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--headless", "--mode", mode]
    subprocess.run([*command, "--duration", str(DURATION_S), "--out", str(folder)], check=True)  # noqa: S603 - ours
    return next(folder.glob("*.mcap"))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
