"""The compose file and the Dockerfile agree with the table of processes and with the command line."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from passafe_protocol.topics import PROCESSES
from passafe_services.cli.app import app
from passafe_services.keys.deployment import identities_of
from passafe_services.loop.realtime import LOOPS
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[2]
COMPOSE: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")

every_service = pytest.mark.parametrize("name", SERVICES)


def with_defaults(text: str) -> str:
    """Return text in which each ``${NAME:-default}`` has its default; podman-compose knows no empty one."""
    return re.sub(r"\$\{\w+:-([^}]+)\}", r"\1", text)


def test_there_is_one_service_for_each_process() -> None:
    assert set(SERVICES) == set(PROCESSES)


@every_service
def test_service_runs_its_process_with_real_options(name: str) -> None:
    command = SERVICES[name]["command"]
    environment = {key: with_defaults(value) for key, value in SERVICES[name]["environment"].items()}

    assert command[:2] == ["run", name]
    assert "$" not in "".join(environment.values())
    assert CliRunner().invoke(app, [*command, "--help"], env=environment).exit_code == 0
    known = CliRunner().invoke(app, ["run", "--help"], env={"COLUMNS": "200"}).output
    assert {variable for variable in environment if variable not in known} == set()


@every_service
def test_service_is_confined(name: str) -> None:
    service = SERVICES[name]

    assert service["read_only"] is True
    assert service["user"] == "10001:10001"
    assert service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert service.get("cap_add", []) == ([] if name == "dashboard" else ["SYS_NICE"])
    assert "privileged" not in service
    assert {"mem_limit", "cpus", "pids_limit"} <= set(service)
    assert service["restart"] == "unless-stopped"


@every_service
def test_service_asks_its_loop_for_health(name: str) -> None:
    check = SERVICES[name]["healthcheck"]["test"]

    assert check == ["CMD", "python3", "-P", "-m", "passafe_services.cli.health", name]


@every_service
def test_service_has_its_own_keys_alone(name: str) -> None:
    holders = {identity.role: identity.common_name for identity in identities_of(["robot"], [], [""])}
    mounted = [with_defaults(with_defaults(volume)) for volume in SERVICES[name]["volumes"] if "/keys" in volume]

    assert mounted == [f"./keys/{holders[name]}:/keys:ro"]
    assert SERVICES[name]["environment"]["PASSAFE_KEYS"] == "/keys"
    assert "PASSAFE_INSECURE" not in SERVICES[name]["environment"]


def test_loops_may_have_realtime_priority() -> None:
    for name in LOOPS:
        assert "rtprio" in SERVICES[name]["ulimits"]


def test_nothing_but_the_page_is_published() -> None:
    published = {name: service["ports"] for name, service in SERVICES.items() if "ports" in service}

    assert {name: [with_defaults(port) for port in ports] for name, ports in published.items()} == {
        "dashboard": ["127.0.0.1:8080:8080"]
    }
    assert COMPOSE["networks"]["bus"] == {"internal": True}
    assert {name for name, service in SERVICES.items() if service["networks"] != ["bus"]} == {"dashboard"}


def test_services_start_in_the_order_of_the_processes() -> None:
    for name, service in SERVICES.items():
        waited_for = service.get("depends_on", {})
        assert all(PROCESSES.index(other) < PROCESSES.index(name) for other in waited_for)
        assert {dependency["condition"] for dependency in waited_for.values()} <= {"service_healthy"}
    assert all("recorder" in SERVICES[name]["depends_on"] for name in ("operator", "filter", "plant"))  # stopped later
    assert set(SERVICES["plant"]["depends_on"]) == set(PROCESSES) - {"plant", "dashboard"}


def test_logs_outlive_the_containers() -> None:
    assert SERVICES["recorder"]["volumes"][-1] == "logs:/logs"
    assert "logs" in COMPOSE["volumes"]


def test_image_is_built_on_any_base_and_runs_without_root() -> None:
    instructions = [line.split(maxsplit=1) for line in DOCKERFILE.splitlines() if re.match(r"[A-Z]+ ", line)]
    stages = [rest for word, rest in instructions if word == "FROM"]

    assert stages == ["${BASE} AS build", "${BASE}"]
    assert with_defaults(COMPOSE["x-process"]["build"]["args"]["BASE"]) == _argument("BASE")
    assert [rest for word, rest in instructions if word == "USER"] == [SERVICES["filter"]["user"]]
    assert [rest for word, rest in instructions if word == "ENTRYPOINT"] == ['["passafe"]']


def test_image_is_built_from_files_that_exist() -> None:
    kept = [line[1:] for line in (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines() if line[:1] == "!"]

    assert {"pyproject.toml", "constraints.txt", "passafe", "protocol", "services", "dashboard"} <= set(kept)
    assert all((ROOT / name).exists() for name in kept)


def _argument(name: str) -> str:
    found = re.search(rf"^ARG {name}=(.+)$", DOCKERFILE, flags=re.MULTILINE)
    assert found is not None
    return found[1]
