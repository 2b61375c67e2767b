"""Every benchmark runs at its smallest size, and its checks hold: answers of peers agree with ours, h ≥ 0."""

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"
LIVE = ("live_flood", "live_kills", "live_latency", "live_page", "live_robots", "live_tls")
PROMPT = "live_stops"
"""Live, too; it judges how soon a stop acts."""

IN_BROWSER = "page_frames"
"""Live, too, with a page in Chromium."""

OTHERS = (
    "campaign_speed",
    "experiment_speed",
    "filter_rows",
    "filter_step",
    "gatekeeper_step",
    "uncertain_step",
    "human_input",
    "lockstep_kills",
    "lockstep_speed",
    "log_rate",
    "prediction_cost",
    "replay_speed",
)
PLAIN = ("mutation", "write_page")


def run(name: str, *options: str) -> str:
    command = [sys.executable, str(FOLDER / f"{name}.py"), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check(name: str) -> None:
    report = json.loads(run(name, "--smallest", "--json"))

    assert report["rows"]
    assert all(len(row) == len(report["columns"]) for row in report["rows"])
    assert not report["failures"]
    assert all(math.isfinite(ratio["median"]) for ratio in report["ratios"])


@pytest.mark.parametrize("name", OTHERS)
def test_benchmark_runs_and_its_checks_hold(name: str) -> None:
    check(name)


@pytest.mark.live
@pytest.mark.parametrize(
    "name",
    [*LIVE, pytest.param(PROMPT, marks=pytest.mark.alone), pytest.param(IN_BROWSER, marks=pytest.mark.browser)],
)
def test_live_benchmark_runs_and_its_checks_hold(name: str) -> None:
    if name == IN_BROWSER and not shutil.which("chromium"):
        pytest.skip("Chromium is not installed")
    check(name)


def test_mutation_tries_a_change_of_the_core() -> None:
    assert "1 changes, 1 noticed" in run("mutation", "--smallest")


def test_every_benchmark_is_run_here() -> None:
    scripts = {path.stem for path in FOLDER.glob("*.py") if "typer.run(main)" in path.read_text()}

    assert scripts == {*LIVE, PROMPT, IN_BROWSER, *OTHERS, *PLAIN}


def test_page_has_every_benchmark_that_measures_ratios() -> None:
    [page] = [path.read_text() for path in (FOLDER.parent / "docs").rglob("benchmarks.md")]
    measuring = {path.stem for path in FOLDER.glob("*.py") if "ratios.append" in path.read_text()}

    assert {name for name in measuring if f"## {name}\n" in page} == measuring
