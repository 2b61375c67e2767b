"""``passafe feasibility`` as a user types it."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from passafe_services.cli import app


class Done(NamedTuple):
    """Result of a command."""

    returncode: int
    stdout: str
    stderr: str


Feasibility = Callable[..., Done]


@pytest.fixture
def feasibility(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Feasibility:
    """Run the command in this process, with ``tmp_path`` as its folder, through the console script's ``main``."""

    def run(*arguments: str) -> Done:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("sys.argv", ["passafe", "feasibility", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
        return Done(int(ended.value.code or 0), *capsys.readouterr())

    return run


def test_help_describes_the_atlas(feasibility: Feasibility) -> None:
    done = feasibility("--help")

    assert done.returncode == 0
    for word in ("--axes", "--fix", "--range", "--cells", "--samples", "--seed", "--gain", "Example"):
        assert word in done.stdout


def test_a_map_is_written_and_summed_up(tmp_path: Path, feasibility: Feasibility) -> None:
    """With γ = 1 safety and passivity conflict behind the robot, with γ = 10 they do not (docs/feasibility.md)."""
    options = ("--cells", "12", "--range", "-3,-2", "--samples", "300", "--seed", "4")
    low, high = (feasibility(*options, "--gain", gain, "--out", gain) for gain in ("1", "10"))

    assert (low.returncode, high.returncode) == (0, 0), low.stderr + high.stderr
    assert "at the states that follow" in " ".join(low.stdout.split())
    summaries = [json.loads((tmp_path / gain / "notomista-cai-2020.summary.json").read_text()) for gain in ("1", "10")]
    for summary in summaries:
        assert summary["fixed"] == [2.0, 2.0, -1.0, -1.0]
        assert (summary["slice"]["states"], summary["slice"]["inside"]) == (144, 144)
        assert summary["sample"]["counts"]["states"] == 300
        assert summary["sample"]["hard"]["low"] <= 1.0 <= summary["sample"]["hard"]["high"] + 1e-9
    assert [summary["slice"]["passive"] == 144 for summary in summaries] == [False, True]
    with (tmp_path / "1" / "notomista-cai-2020.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 144
    assert sum(int(row["passive_kept"]) for row in rows) == summaries[0]["slice"]["passive"]
    assert (tmp_path / "1" / "notomista-cai-2020.svg").read_text().startswith("<svg")


def test_other_coordinates_can_be_varied_and_fixed(tmp_path: Path, feasibility: Feasibility) -> None:
    options = ("--scenario", "moving-disk", "--axes", "x2,x0", "--fix", "x3=-0.5", "--fix", "x1=0", "--at", "1")
    done = feasibility(*options, "--range", "-1,1", "--range", "0,3", "--cells", "3", "--samples", "0")
    assert done.returncode == 2
    assert "--out" in done.stderr

    done = feasibility(*options, "--range", "-1,1", "--range", "0,3", "--cells", "3", "--samples", "0", "--out", "a")

    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "a" / "moving-disk.summary.json").read_text())
    assert (summary["across"], summary["up"], summary["sample"], summary["plant_time_s"]) == (2, 0, None, 1.0)
    with (tmp_path / "a" / "moving-disk.csv").open() as file:
        first = next(csv.DictReader(file))
    assert (float(first["x0"]), float(first["x1"]), float(first["x3"])) == (0.5, 0.0, -0.5)
    assert float(first["x2"]) == pytest.approx(-2 / 3)
    assert float(first["h"]) == pytest.approx(1.0 - 0.25)  # the disk's centre is at 1.5 by then


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--scenario", "nonsense"), "notomista-cai-2020"),
        (("--axes", "x0"), "--axes"),
        (("--axes", "x0,x4"), "x0 to x3"),
        (("--axes", "x1,x1"), "two different"),
        (("--axes", "x0,speed"), "speed"),
        (("--fix", "x2"), "NAME=VALUE"),
        (("--fix", "x9=1"), "x9"),
        (("--fix", "x0=1"), "--fix"),
        (("--fix", "x2=fast"), "fast"),
        (("--fix", "x2=inf"), "finite"),
        (("--range", "1,1"), "--range"),
        (("--range", "3,-3"), "--range"),
        (("--range", "1"), "--range"),
        (("--range", "0,1", "--range", "0,1", "--range", "0,1"), "--range"),
        (("--low", "1,2"), "--low"),
        (("--low", "1", "--high", "0"), "--low"),
        (("--gain", "0"), "--gain"),
        (("--gain", "nan"), "--gain"),
        (("--at", "nan"), "--at"),
        (("--out", "/proc/no"), "/proc/no"),
    ],
)
def test_nonsense_gets_one_clear_line(
    arguments: tuple[str, ...], named: str, tmp_path: Path, feasibility: Feasibility
) -> None:
    done = feasibility("--out", "x", *arguments)

    assert done.returncode == 2
    assert named in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_continuous_law_is_refused(tmp_path: Path, feasibility: Feasibility) -> None:
    from passafe_services.scenarios.load import load_scenario  # noqa: PLC0415 - only this test needs it

    path = tmp_path / "continuous.json"
    path.write_text(load_scenario("notomista-cai-2020", {"filter.law": "continuous"}).model_dump_json())
    done = feasibility("--scenario", str(path), "--out", "x")

    assert done.returncode == 2
    assert "filter.law: got continuous, allowed sampled" in done.stderr
    assert not (tmp_path / "x").exists()
