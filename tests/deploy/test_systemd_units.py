"""The systemd units have the properties of the compose file, and systemd accepts them."""

import shutil
import subprocess
from configparser import RawConfigParser
from pathlib import Path
from typing import Any

import pytest
import yaml
from passafe_protocol.topics import PROCESSES
from passafe_services.cli.app import app
from passafe_services.loop.health_report import SILENCE_S
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[2]
UNIT = ROOT / "deploy/systemd/passafe@.service"
SETTINGS = ROOT / "deploy/systemd/passafe.env"
COMPOSE: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))["x-process"]


@pytest.fixture
def service() -> dict[str, str]:
    parser = RawConfigParser(strict=False)  # of a repeated name the last value counts
    parser.optionxform = str  # type: ignore[assignment,method-assign]  # names keep their case
    parser.read(UNIT, encoding="utf-8")
    return dict(parser["Service"])


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
@pytest.mark.parametrize("process", PROCESSES)
def test_systemd_accepts_the_unit(process: str, tmp_path: Path) -> None:
    unit = tmp_path / f"passafe@{process}.service"
    installed = UNIT.read_text(encoding="utf-8").replace("/opt/passafe/bin/passafe", str(Path("/bin/true").resolve()))
    unit.write_text(installed, encoding="utf-8")

    command = ("systemd-analyze", "verify", "--man=no", str(unit))
    done = subprocess.run(command, capture_output=True, text=True, check=False)

    assert (done.returncode, done.stderr) == (0, "")


def test_unit_runs_any_process(service: dict[str, str]) -> None:
    assert service["ExecStart"] == "/opt/passafe/bin/passafe run %i"


def test_watchdog_waits_as_long_as_health(service: dict[str, str]) -> None:
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) == SILENCE_S
    assert service["WatchdogSignal"] == "SIGKILL"
    assert service["Restart"] == "always"


def test_unit_is_confined_as_a_container_is(service: dict[str, str]) -> None:
    assert service["User"] == "passafe"
    assert service["ProtectSystem"] == "strict"
    assert service["NoNewPrivileges"] == "yes"
    assert service["CapabilityBoundingSet"] == service["AmbientCapabilities"] == "CAP_SYS_NICE"


def test_limits_are_those_of_a_container(service: dict[str, str]) -> None:
    assert int(service["LimitNOFILE"]) == COMPOSE["ulimits"]["nofile"]["hard"]
    assert int(service["LimitNPROC"]) == COMPOSE["ulimits"]["nproc"]["hard"]
    assert int(service["TasksMax"]) == COMPOSE["pids_limit"]
    assert service["MemoryMax"] == COMPOSE["mem_limit"].upper()
    assert service["CPUQuota"] == f"{COMPOSE['cpus']:.0%}"
    assert int(service["LimitRTPRIO"]) == 99


def test_settings_are_options_of_run(service: dict[str, str]) -> None:
    lines = [line for line in SETTINGS.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    known = CliRunner().invoke(app, ["run", "--help"], env={"COLUMNS": "200"}).output

    names = [line.split("=")[0] for line in (*lines, *service["Environment"].split())]
    assert len(names) == 6
    assert all(name in known for name in names)
