"""The simulated person fitted to the commands in a log."""

from pathlib import Path
from typing import Any

import pytest
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.errors import ChangeError
from passafe_services.tools.what_if.human_fit import fit_human


def recorded(path: Path, **overrides: Any) -> RunLog:  # noqa: ANN401 - any value of a scenario
    changes = {
        "rate_hz": 125.0,
        "duration_s": 3.0,
        **{key.replace("__", "."): value for key, value in overrides.items()},
    }
    scenario = load_scenario(changes.pop("name"), changes)
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        lockstep_loop(scenario, LockstepLog(writer)).run(steps_of(scenario))
    return RunLog.read(path)


def test_person_without_remnant_is_found_again(tmp_path: Path) -> None:
    log = recorded(
        tmp_path / "run.mcap",
        name="human-steers",
        operator__source__remnant=0.0,
        operator__source__crossover_rad_per_s=1.3,
        operator__source__reaction_s=0.26,
        operator__source__neuromuscular_s=0.15,
    )
    fit = fit_human(log, log.identity.scenario)
    assert fit.crossover_rad_per_s == pytest.approx(1.3, rel=0.02)
    assert fit.reaction_s == pytest.approx(0.26, abs=0.02)
    assert fit.neuromuscular_s == pytest.approx(0.15, abs=0.03)
    assert fit.explained > 0.99
    assert fit.text.startswith("simulated person fitted to ")


@pytest.mark.campaign
def test_remnant_is_what_the_fit_does_not_explain(tmp_path: Path) -> None:
    log = recorded(tmp_path / "run.mcap", name="human-steers")
    fit = fit_human(log, log.identity.scenario)
    assert 0.6 < fit.explained < 0.999
    assert fit.rms_error > 0.1


def test_script_has_nobody_to_fit(tmp_path: Path) -> None:
    log = recorded(tmp_path / "run.mcap", name="notomista-cai-2020", duration_s=0.4)
    with pytest.raises(ChangeError, match="got human for a log whose operator is of kind lag"):
        fit_human(log, log.identity.scenario)


def test_commands_of_somebody_else_are_refused(tmp_path: Path) -> None:
    source = {"kind": "sine", "amplitude": [3.0, 3.0], "frequency_hz": 3.0}
    log = recorded(tmp_path / "run.mcap", name="human-steers", operator__source=source, duration_s=1.0)
    with pytest.raises(ChangeError, match=r"who explains .* of the commands at best, allowed a log"):
        fit_human(log, load_scenario("human-steers"))


def test_few_commands_are_refused(tmp_path: Path) -> None:
    log = recorded(tmp_path / "run.mcap", name="human-steers", duration_s=0.2)
    with pytest.raises(ChangeError, match=r"got human for a log with 2\d commands"):
        fit_human(log, log.identity.scenario)
