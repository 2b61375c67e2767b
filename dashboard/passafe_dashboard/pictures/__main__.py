"""Draw the README's pictures: the reference scenario in each mode.

``python -m passafe_dashboard.pictures FOLDER`` runs it live and draws the logs;
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

from passafe_dashboard.pictures.run_picture import run_picture
from passafe_dashboard.run_series import series_of

MODES: Final = ("off", "passive", "safe", "both")
DURATION_S: Final = 10


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
    """Draw pictures; return the exit code."""
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
    """Run the reference scenario live and return its log."""
    folder = scratch / mode
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--headless", "--mode", mode]
    subprocess.run([*command, "--duration", str(DURATION_S), "--out", str(folder)], check=True)  # noqa: S603 - ours
    return next(folder.glob("*.mcap"))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
