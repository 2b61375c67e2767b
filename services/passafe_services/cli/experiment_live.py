"""Compares cells of an experiment, run as real processes, with the same in lockstep."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from socket import create_server
from typing import Final

from rich.console import Console
from rich.table import Table

from passafe_services.cli.demo_outcome import DIED
from passafe_services.loop.router_endpoint import LOOPBACK
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.experiment.cells import Cell, run_of
from passafe_services.tools.experiment.errors import LiveRunError
from passafe_services.tools.experiment.live_agreement import Agreement, compare, draws_of, until
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

START_S: Final = 120.0
"""How long a live system may take beyond its duration, start and end together, on a loaded machine."""


def live_beside_lockstep(plan: Plan, study: Study, most: int, folder: Path, console: Console) -> list[Agreement]:
    """Run cells live and in lockstep, and compare them.

    Args:
        plan: The experiment.
        study: The same with its scenario.
        most: How many cells, spread evenly over all.
        folder: Where the logs go.
        console: Where progress is printed.

    Raises:
        LiveRunError: A live run left no log.
    """
    runner, found = StudyRunner(study), []
    for cell in spread(plan.cells, most):
        axis = study.experiment.bisected
        run = run_of(study.experiment, cell, study.experiment.seeds.first, None if axis is None else axis.low)
        scenario = runner.scenario_of(run)
        console.print(f"live      {cell.describe()}: {scenario.duration_s:g} s as real processes")
        verdict = run_live(scenario, folder / f"cell-{cell.number}")
        lockstep = [runner.metrics(draw, until_its_end=True) for draw in draws_of(scenario)]
        found += compare(cell.describe(), verdict, lockstep)
    return found


def spread(cells: Sequence[Cell], most: int) -> list[Cell]:
    """Return ``most`` cells, evenly spread; the first and the last are among them if ``most`` is above 1."""
    if most >= len(cells):
        return list(cells)
    if most == 1:
        return [cells[0]]
    return [cells[round(k * (len(cells) - 1) / (most - 1))] for k in range(most)]


def run_live(scenario: Scenario, folder: Path) -> Verdict:
    """Run a scenario as `passafe demo` does, without a page, and return the verdict on its log.

    Raises:
        LiveRunError: The run left no log, or one of its processes died.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scenario.json"
    file.write_text(scenario.model_dump_json(indent=2), encoding="utf-8")
    before = set(folder.glob("*.mcap"))
    options = ["--duration", str(scenario.duration_s), "--router-port", str(_free_port()), "--out", str(folder)]
    command = [
        sys.executable,
        "-P",
        "-m",
        "passafe_services.cli",
        "demo",
        "--headless",
        "--scenario",
        str(file),
        *options,
    ]
    done = subprocess.run(  # noqa: S603 - our own command
        command, capture_output=True, text=True, check=False, timeout=scenario.duration_s + START_S
    )
    logs = sorted(set(folder.glob("*.mcap")) - before)
    if not logs or done.returncode == DIED:
        lines = (done.stdout + done.stderr).strip().splitlines()
        reasons = [line for line in lines if " died" in line] or lines[-1:]
        raise LiveRunError(file, " ".join(reasons[:1]) or f"exit code {done.returncode}")
    return Verdict.of(until(RunLog.read(logs[-1]), scenario.duration_s), CoreEvaluator(scenario))


def show_agreement(found: Sequence[Agreement], console: Console) -> None:
    """Print the metrics that disagree, and how many agree."""
    wrong = [one for one in found if not one.agrees]
    table = Table("cell", "metric", "live", "lockstep", "outside by", "allowed", title="Live beside lockstep")
    for one in wrong:
        between = _number(one.low) if one.low == one.high else f"{_number(one.low)} to {_number(one.high)}"
        difference, allowed = _number(one.difference), _number(one.tolerance)
        table.add_row(one.cell, one.metric, _number(one.live), between, difference, allowed)
    if wrong:
        console.print(table)
    console.print(f"agreement {len(found) - len(wrong)} of {len(found)} metrics, live beside lockstep")


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def _free_port() -> int:
    with create_server((LOOPBACK, 0)) as server:
        return int(server.getsockname()[1])
