"""``passafe health`` judges by what the loop reports; ``passafe run`` takes its options from the environment."""

from pathlib import Path

import pytest
from passafe_services.cli.app import app
from passafe_services.cli.log_name import log_path
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.plant import process as plant_process
from passafe_services.scenarios.load import load_scenario
from typer.testing import CliRunner


def test_health_passes_while_the_loop_reports(tmp_path: Path) -> None:
    HealthReporter("operator", tmp_path).report(connected=True, steps=1000, skipped=0)

    result = CliRunner().invoke(app, ["health", "operator", "--folder", str(tmp_path)])

    assert (result.exit_code, result.output) == (0, "operator: healthy\n")


def test_health_fails_without_a_router(tmp_path: Path) -> None:
    HealthReporter("operator", tmp_path).report(connected=False, steps=1000, skipped=0)

    result = CliRunner().invoke(app, ["health", "operator"], env={"PASSAFE_HEALTH": str(tmp_path)})

    assert (result.exit_code, result.output) == (1, "operator: unhealthy: no router is connected\n")


def test_health_fails_without_a_report(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["health", "router", "--folder", str(tmp_path)])

    assert (result.exit_code, result.output) == (1, f"router: unhealthy: no report in {tmp_path}\n")


def test_run_takes_its_options_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[ProcessOptions] = []
    monkeypatch.setattr(plant_process, "start", given.append)
    environment = {
        "PASSAFE_SCENARIO": "lagged-point",
        "PASSAFE_ROUTER": "router:7448",
        "PASSAFE_ROBOT": "r7",
        "PASSAFE_HOST": "0.0.0.0",  # noqa: S104 - nothing listens
        "PASSAFE_PORT": "8181",
        "PASSAFE_PAGE_NAME": "robot.example",
        "PASSAFE_OUT": str(tmp_path),
        "PASSAFE_START_STOPPED": "0",
        "PASSAFE_INSECURE": "1",
        "PASSAFE_HEALTH": str(tmp_path),
    }

    result = CliRunner().invoke(app, ["run", "plant"], env=environment)

    assert result.exit_code == 0, result.output
    [options] = given
    assert options.scenario.name == "lagged-point"
    assert options.endpoint.locator == "tcp/router:7448"
    assert options.robot == "r7"
    assert (options.host, options.port) == ("0.0.0.0", 8181)  # noqa: S104 - nothing listens
    assert not options.start_stopped
    assert options.page_names == ("robot.example",)
    assert options.out.parent == tmp_path
    assert options.health.wanted


def test_log_in_a_folder_replaces_no_other(tmp_path: Path) -> None:
    scenario = load_scenario("notomista-cai-2020")
    paths = []
    for _ in range(3):
        paths.append(log_path(tmp_path, scenario))
        paths[-1].touch()

    assert len(set(paths)) == 3
    assert all(path.name.startswith("notomista-cai-2020-both-") for path in paths)
    assert log_path(tmp_path / "run.mcap", scenario) == tmp_path / "run.mcap"
