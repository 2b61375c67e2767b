"""The guide to a barrier of one's own, followed to the letter: filter, page, review and report know its kind."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "how-to" / "own-barrier.md"

PAGE = """
import sys
from pathlib import Path
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.page import LivePage
from passafe_protocol.messages import PlantState
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.run_log import RunLog

feed = Feed(load_scenario("table.toml"))
for message in RunLog.read(Path(sys.argv[1])).of(PlantState):
    feed.push(message.header, message.body, 0)
print(feed.run.worst["h_0"].value, feed.layout.h_unit, feed.displacements_m(feed.run.state))
assert "table" in LivePage(feed, window_s=20.0).html()
"""


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def passafe(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return run(folder, "-P", "-m", "passafe_services.cli", *arguments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the guide's files, laid out like an installed distribution."""
    folder = tmp_path_factory.mktemp("own")
    kind, _ = blocks("python")
    project, scenario = blocks("toml")
    header = '[project.entry-points."passafe.barrier_kinds"]\n'
    assert project.startswith(header)
    (folder / "my_barriers").mkdir()
    (folder / "my_barriers" / "rounded_box.py").write_text(kind, encoding="utf-8")
    (folder / "table.toml").write_text(scenario, encoding="utf-8")
    information = folder / "my_barriers-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: my-barriers\nVersion: 1.0\n", encoding="utf-8")
    entries = "[passafe.barrier_kinds]\n" + project.removeprefix(header).replace('"', "")
    (information / "entry_points.txt").write_text(entries, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    done = passafe(folder, "simulate", "--scenario", "table.toml", "--out", "table.mcap")
    assert done.returncode == 0, done.stderr
    return folder / "table.mcap"


@pytest.fixture(scope="module")
def verdict(folder: Path, log: Path) -> dict[str, object]:
    done = passafe(folder, "review", log.name, "--html", "table.html", "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    found: dict[str, object] = json.loads(done.stdout)
    return found


def test_filter_keeps_the_new_barrier(folder: Path, verdict: dict[str, object]) -> None:
    assert verdict["verdict"] == "holds"
    assert 0 <= float(str(verdict["h_min"])) < 0.1
    assert verdict["h_min_barrier"] == "table"
    off = passafe(folder, "simulate", "--scenario", "table.toml", "--out", "off.mcap", "--mode", "off")
    assert off.returncode == 0, off.stderr
    without = json.loads(passafe(folder, "review", "off.mcap", "--json").stdout)
    assert without["h_min"] < -0.9


def test_report_draws_the_new_barrier(folder: Path, verdict: dict[str, object]) -> None:
    report = (folder / "table.html").read_text(encoding="utf-8")
    assert "Obstacles: table." in report
    assert "Barriers h over plant time. table from" in report
    assert verdict["h_min_barrier"] == "table"


def test_page_evaluates_and_moves_the_new_barrier(folder: Path, log: Path, verdict: dict[str, object]) -> None:
    done = run(folder, "-c", PAGE, log.name)
    assert done.returncode == 0, done.stderr
    lowest, rest = done.stdout.split(maxsplit=1)
    assert float(lowest) == pytest.approx(float(str(verdict["h_min"])), abs=1e-3)
    assert re.fullmatch(r"1 \{'moving_0': \(0\.0, -?0\.\d+\)\}\n", rest)


def test_outline_of_the_guide_is_where_h_is_zero(folder: Path) -> None:
    _, check = blocks("python")
    done = run(folder, "-c", check)
    assert done.stdout == "True\n", done.stderr


def test_misspelt_key_of_the_new_kind_is_refused_with_a_hint(folder: Path) -> None:
    text = (folder / "table.toml").read_text(encoding="utf-8").replace("half_width_m", "half_widht_m")
    (folder / "misspelt.toml").write_text(text, encoding="utf-8")
    done = passafe(folder, "simulate", "--scenario", "misspelt.toml", "--out", "none.mcap")
    assert done.returncode == 2
    assert "did you mean half_width_m?" in done.stderr
