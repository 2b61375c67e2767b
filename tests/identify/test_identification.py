"""One minute of driving with a known truth: parameters, noise and disturbance come back; sets explain the log."""

from pathlib import Path
from typing import Any

import pytest
from passafe_services.cli.app import app
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.identify.errors import IdentifyError
from passafe_services.tools.identify.identification import Identification, identify
from passafe_services.tools.identify.motion_log import motion_of
from typer.testing import CliRunner

TRUTH: dict[str, Any] = {
    "parameters": {"mass": 1.2, "sigma": 0.8},
    "noise": {"bound": {"position": 0.001, "velocity": 0.01}},
    "disturbance": {"kind": "switching", "bound": {"velocity": 0.3}, "every_s": 1.3},
}
TARGETS = [{"at_s": 3.0 * k, "position": [2.0 * (-1) ** k, 1.0 * (-1) ** (k // 2)]} for k in range(20)]


def drive(path: Path, **overrides: Any) -> Path:  # noqa: ANN401 - fields of a scenario
    fields = {"duration_s": 60.0, "rate_hz": 25.0, "filter.mode": "off", "filter.k_i": 20.0, "plant.truth": TRUTH}
    fields["operator.source.targets"] = TARGETS
    scenario = load_scenario("human-steers", fields | {k.replace("__", "."): v for k, v in overrides.items()})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        loop = lockstep_loop(scenario, LockstepLog(log))
        loop.run(steps_of(scenario))
        loop.finish()
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drive(tmp_path_factory.mktemp("identify") / "drive.mcap")


@pytest.fixture(scope="module")
def found(log: Path) -> Identification:
    return identify(motion_of([log]))


def test_parameters_and_noise_come_back(found: Identification) -> None:
    assert found.parameters["mass"] == pytest.approx(1.2, rel=0.02)
    assert found.parameters["sigma"] == pytest.approx(0.8, rel=0.10)
    assert found.noise[:2] == pytest.approx((0.001 / 3**0.5,) * 2, rel=0.2)
    assert found.noise[2:] == pytest.approx((0.01 / 3**0.5,) * 2, rel=0.2)


def test_sets_explain_what_they_claim(found: Identification) -> None:
    assert found.left_out <= 1e-3
    assert found.disturbance[:2] == (0.0, 0.0)
    assert 0.1 < found.disturbance[2] < 0.6
    for name, (low, high) in found.intervals.items():
        assert low < found.parameters[name] < high


def test_scenario_lines_are_a_scenario(found: Identification, tmp_path: Path) -> None:
    lines = found.scenario_lines()
    file = tmp_path / "found.toml"
    shipped = Path("services/passafe_services/scenarios/human-steers.toml").read_text(encoding="utf-8")
    parameters = next(line for line in lines.splitlines() if line.startswith("parameters"))
    file.write_text(
        shipped.replace("parameters = { sigma = 1.0 }", parameters) + lines.partition("\n\n")[2], encoding="utf-8"
    )

    scenario = load_scenario(str(file))

    assert scenario.plant.parameters["mass"] == found.parameters["mass"]
    assert scenario.uncertainty is not None
    assert scenario.uncertainty.parameters["mass"] == found.intervals["mass"]


def test_what_cannot_be_estimated_is_refused(log: Path) -> None:
    with pytest.raises(IdentifyError, match="did you mean mass"):
        identify(motion_of([log]), ["mas"])
    with pytest.raises(IdentifyError, match="--window"):
        identify(motion_of([log]), window_s=100.0)


def test_logs_of_two_rates_are_refused(log: Path, tmp_path: Path) -> None:
    other = drive(tmp_path / "other.mcap", duration_s=1.0, rate_hz=100.0)

    with pytest.raises(IdentifyError, match="one robot and rate"):
        motion_of([log, other])


def test_a_log_without_motion_is_refused(tmp_path: Path) -> None:
    still = drive(tmp_path / "still.mcap", duration_s=0.02)
    with pytest.raises(IdentifyError):
        identify(motion_of([still]))


def test_the_command_prints_and_writes_the_lines(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "lines.toml"

    result = CliRunner().invoke(app, ["identify", str(log), "--parameter", "mass", "--out", str(out)])

    assert result.exit_code == 0, result.output
    assert "mass" in result.output
    assert "[uncertainty]" in out.read_text(encoding="utf-8")
    assert out.read_text(encoding="utf-8").strip() in result.output
