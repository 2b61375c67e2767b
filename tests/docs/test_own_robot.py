"""The guide to a robot of one's own, followed word by word, its Python file deleted before the log is read."""

import json
import os
import re
import tomllib
from pathlib import Path

import pytest
from passafe_services.cli.app import app
from passafe_services.scenarios.errors import ScenarioError
from typer.testing import CliRunner, Result

GUIDE = (Path(__file__).parents[2] / "docs" / "how-to" / "own-robot.md").read_text(encoding="utf-8")
COMMANDS = [line.strip().split()[1:] for line in GUIDE.splitlines() if line.startswith("    passafe ")]


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", GUIDE, flags=re.DOTALL)
    assert found is not None
    return found[1]


def passafe(folder: Path, *arguments: str) -> Result:
    before = Path.cwd()
    os.chdir(folder)
    try:
        return CliRunner().invoke(app, list(arguments))
    finally:
        os.chdir(before)


def command(name: str) -> list[str]:
    return next(words for words in COMMANDS if words[0] == name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the log of the guide's robot, and without its Python file."""
    folder = tmp_path_factory.mktemp("car")
    (folder / "car.py").write_text(block("python"), encoding="utf-8")
    (folder / "car.toml").write_text(block("toml"), encoding="utf-8")
    done = passafe(folder, *command("simulate"), "--duration", "1")
    assert done.exit_code == 0, done.output
    (folder / "car.py").unlink()
    return folder


@pytest.fixture(scope="module")
def review(folder: Path) -> Result:
    """Return what the guide's review of the log printed; its page is in the folder."""
    return passafe(folder, *command("review"), "--json")


def test_robot_and_scenario_take_less_than_60_lines() -> None:
    assert len(block("python").splitlines()) + len(block("toml").splitlines()) < 60


def test_log_is_reviewed_without_the_file(folder: Path, review: Result) -> None:
    assert review.exit_code == 0, review.output
    verdict = json.loads(review.stdout)
    assert verdict["verdict"] == "holds"
    assert verdict["status_counts"]["MODIFIED"] > 100
    assert (folder / "car.html").stat().st_size > 10_000


def test_log_is_replayed_bit_for_bit_without_the_file(folder: Path) -> None:
    done = passafe(folder, *command("replay"))

    assert done.exit_code == 0, done.output
    ticks, _, of = done.stdout.split()[:3]
    assert ticks == of


def test_what_if_changes_a_parameter_without_the_file(folder: Path) -> None:
    done = passafe(folder, *command("whatif"))

    assert "moves     robot elsewhere" in done.stdout, done.output


@pytest.mark.usefixtures("review")
def test_posts_are_drawn(folder: Path) -> None:
    scenario = tomllib.loads(block("toml"))
    drawn = {one["name"]: (tuple(one["centre"]), one["radius"]) for one in scenario["filter"]["barriers"]}

    assert drawn == {"left post": ((2.0, 1.1), 0.5), "right post": ((2.5, -1.0), 0.5)}
    assert "left post, right post" in (folder / "car.html").read_text(encoding="utf-8")


def test_scenario_alone_runs_no_code(folder: Path) -> None:
    done = passafe(folder, "check", "car.toml")

    assert isinstance(done.exception, ScenarioError)
    assert "plant.model: got 'car', allowed 'damped-point'" in str(done.exception)
    assert len(str(done.exception).splitlines()) == 1
