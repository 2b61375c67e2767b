"""``passafe check`` as a user types it, and the warnings of commands that run a scenario."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from passafe_services.cli import app
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tools.check.scenario_check import load_findings, scenario_findings

from passafe.finding import Severity

NAME = "walls-and-disks"


class Done(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


Passafe = Callable[..., Done]


@pytest.fixture
def passafe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Passafe:
    def run(*arguments: str) -> Done:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("COLUMNS", "200")
        monkeypatch.setattr("sys.argv", ["passafe", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
        return Done(int(ended.value.code or 0), *capsys.readouterr())

    return run


def written(folder: Path, overrides: dict[str, Any], name: str = NAME) -> str:
    path = folder / "changed.json"
    path.write_text(load_scenario(name, overrides).model_dump_json())
    return str(path)


def warnings(overrides: dict[str, Any], name: str = NAME) -> dict[str, str]:
    found = load_findings(load_scenario(name, overrides))
    return {f"{one.topic}, {one.subject}": one.found for one in found if one.severity is Severity.WARNING}


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if not name.startswith("arm-")])
def test_nothing_is_warned_of_at_the_load_of_shipped_scenarios(name: str) -> None:
    assert warnings({}, name) == {}


@pytest.mark.parametrize("name", ["notomista-cai-2020", "moving-disk"])
def test_shipped_scenarios_have_notes_only(name: str) -> None:
    """The machine decides whether decisions fit into the period: one finding says so."""
    found = scenario_findings(load_scenario(name), 40, 1)
    of_machine = [one for one in found if one.subject == "decisions"]

    assert len(of_machine) == 1
    assert {one.severity for one in found if one not in of_machine} == {Severity.NOTE}


def test_help_says_what_is_looked_at(passafe: Passafe) -> None:
    done = passafe("check", "--help")

    assert done.returncode == 0
    for word in ("relative degree", "fail-safe", "--samples", "--json", "Example"):
        assert word in done.stdout


def test_a_start_that_moves_too_fast_is_warned_of(tmp_path: Path, passafe: Passafe) -> None:
    path = written(tmp_path, {"plant.x0": [-2.7, -1.0, -4.0, 0.0], "duration_s": 0.05})
    checked = passafe("check", path, "--samples", "16", "--json")
    run = passafe("simulate", "--scenario", path, "--out", "run.mcap")

    assert checked.returncode == 1
    warned = [one for one in json.loads(checked.stdout) if one["severity"] == "warning" and one["topic"] == "start"]
    assert [one["found"] for one in warned] == ["ψ₀ = 0.3, ψ₁ = -1: ψ₁ < 0, outside the set that the rows protect"]
    assert "warning: start, barrier 'room left': ψ₀ = 0.3, ψ₁ = -1" in run.stderr


def test_gains_that_no_held_fail_safe_keeps_are_warned_of() -> None:
    gains = [{"kind": "linear", "gain": 25.0}] * 3
    disk = {"kind": "disk-keep-out", "name": "post", "centre": [3.0, 3.0], "radius": 0.3, "class_k": gains}
    slow = {"rate_hz": 10.0, "filter.k_i": 5.0, "plant.playout_s": 0.1, "filter.barriers": [disk]}

    assert "linear ones up to 20.34 1/s are kept" in warnings(slow)["fail-safe, barrier 'post'"]
    assert warnings(slow | {"rate_hz": 50.0}) == {}
    curved = slow | {
        "rate_hz": 50.0,
        "filter.barriers": [disk | {"class_k": [{"kind": "cubic", "gain": 1.0}, *gains[1:]]}],
    }
    assert "fail-safe, barrier 'post'" in warnings(curved)


def test_a_set_to_stay_in_is_a_note() -> None:
    gains = [{"kind": "linear", "gain": 5.0}] * 3
    pen = {"kind": "disk-keep-in", "name": "pen", "centre": [0.0, 0.0], "radius": 5.0, "class_k": gains}
    found = load_findings(load_scenario(NAME, {"filter.barriers": [pen]}))

    assert "a set to stay in" in next(
        one.found for one in found if one.subject == "barrier 'pen'" and one.topic == "fail-safe"
    )


def test_brakes_too_weak_for_the_speed_are_warned_of() -> None:
    weak = warnings({"filter.input_bound": 5.0})
    assert "at 2 on every axis it asks for 18 of 5" in weak["fail-safe, limits of the input"]
    saturating = {"plant.model": "saturating-point", "plant.parameters": {"force": 4.0}}
    assert "it is proven up to a speed of 0.3" in warnings(saturating)["fail-safe, limits of the input"]


def test_a_play_out_shorter_than_a_period_is_warned_of() -> None:
    assert warnings({"plant.playout_s": 0.0}) == {"play-out, plant.playout_s": "0 s, 0 periods"}


def test_a_design_that_cannot_be_made_is_refused(tmp_path: Path, passafe: Passafe) -> None:
    path = written(tmp_path, {"filter.barriers.left.class_k": [{"kind": "linear", "gain": 5.0}]})
    checked = passafe("check", path)
    run = passafe("simulate", "--scenario", path, "--out", "run.mcap")

    assert (checked.returncode, run.returncode) == (2, 2)
    assert "allowed is 3: relative degree 2 and one more" in checked.stdout
    assert "barrier 'left' class_k: got 1 functions, allowed 3: relative degree 2 and one more" in run.stderr
