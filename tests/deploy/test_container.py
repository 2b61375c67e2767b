"""The compose file, really run: `make container-test`."""

import os
import platform
import shutil
import signal
import socket
import ssl
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from built_image import BASE, IMAGE, ROOT, build_image, import_debian_base
from passafe_protocol.topics import PROCESSES
from passafe_services.cli.app import app
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from podman_host import NEEDED, PACKAGES, PodmanHost
from typer.testing import CliRunner

pytestmark = pytest.mark.container

CONTAINER_USER = 10_001
PATIENCE_S = 120.0
DRIVEN_S = 8.0
RATE_HZ = 250.0
PAGE_TOKEN = "token-of-the-container-tests"  # noqa: S105 - of this test alone
"""Low enough for two processors that other programs use, too."""


@dataclass(frozen=True, kw_only=True)
class Deployment:
    """The compose file's containers on one host."""

    host: PodmanHost
    environment: dict[str, str]

    def compose(self, *command: str) -> None:
        self.host.run(
            "podman-compose", "--project-name", "passafe-test", *command, environment=self.environment, cwd=ROOT
        )

    def container(self, process: str) -> str:
        return f"passafe-test_{process}_1"

    def healthy(self, process: str) -> bool:
        """Run the health check once; without systemd, podman has no timer that would."""
        return self.host.run("podman", "healthcheck", "run", self.container(process), check=False).returncode == 0

    def wait_until_healthy(self, *processes: str) -> None:
        end = time.monotonic() + PATIENCE_S
        for process in processes:
            while not self.healthy(process):
                output = self.host.run("podman", "logs", self.container(process), check=False)
                assert time.monotonic() < end, f"{process} is not healthy: {output.stdout}{output.stderr}"
                time.sleep(0.5)  # each check starts a process: not more often

    def pid(self, process: str) -> int:
        return int(self.host.inspect(self.container(process))["State"]["Pid"])

    def logs(self) -> list[Path]:
        mounted = self.host.run("podman", "volume", "inspect", "passafe-test_logs", "--format", "{{.Mountpoint}}")
        return sorted(Path(mounted.stdout.strip()).glob("*.mcap"))


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PodmanHost]:
    """Make a host with the image, or fail and say what is missing."""
    missing = [program for program in NEEDED if shutil.which(program) is None]
    if missing or os.geteuid() != 0:
        pytest.fail(f"needs root, and of Debian: apt-get install --no-install-recommends {' '.join(PACKAGES)}")
    folder = tmp_path_factory.mktemp("podman")
    host = PodmanHost(folder=folder / "host")
    host.prepare()
    try:
        suite = platform.freedesktop_os_release().get("VERSION_CODENAME", "bookworm")
        build_image(host, folder, import_debian_base(host, folder, suite))
        yield host
    finally:
        host.remove()
        shutil.rmtree(folder, ignore_errors=True)


def readable_keys(folder: Path) -> Path:
    """Make the keys of a deployment whose router is reached as `router`, readable for the containers' user."""
    result = CliRunner().invoke(app, ["keys", "make", str(folder), "--host", "router"])
    assert result.exit_code == 0, result.output
    give_to_containers(folder)
    return folder


def give_to_containers(folder: Path) -> None:
    """Make a folder and what is in it the containers' own: pytest makes folders for its user alone."""
    for path in (folder, *folder.rglob("*")):
        os.chown(path, CONTAINER_USER, CONTAINER_USER)


@pytest.fixture(scope="module")
def deployment(host: PodmanHost, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Deployment]:
    """Start the system with a scenario file of one's own and wait until it is healthy."""
    scenarios = tmp_path_factory.mktemp("scenarios")
    own = load_scenario("notomista-cai-2020", {"rate_hz": RATE_HZ}).model_dump_json()
    (scenarios / "mine.json").write_text(own, encoding="utf-8")
    give_to_containers(scenarios)
    keys = readable_keys(tmp_path_factory.mktemp("keys"))
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    environment = {
        "PASSAFE_IMAGE": IMAGE,
        "PASSAFE_PAGE": f"127.0.0.1:{port}",
        "PASSAFE_PAGE_TOKEN": PAGE_TOKEN,
        "PASSAFE_KEYS": str(keys),
        "PASSAFE_SCENARIOS": str(scenarios),
        "PASSAFE_SCENARIO": "/scenarios/mine.json",
    }
    deployment = Deployment(host=host, environment=environment)
    deployment.compose("up", "--detach", "--no-build")
    try:
        deployment.wait_until_healthy(*PROCESSES)
        yield deployment
    finally:
        deployment.compose("down", "--volumes")


def test_image_is_small(host: PodmanHost) -> None:
    sizes = [
        int(host.run("podman", "image", "inspect", name, "--format", "{{.Size}}").stdout) for name in (IMAGE, BASE)
    ]

    assert sizes[0] - sizes[1] < 450e6


@pytest.mark.parametrize("process", PROCESSES)
def test_container_is_confined(deployment: Deployment, process: str) -> None:
    name = deployment.container(process)
    found = deployment.host.inspect(name)
    inside = "id -u; touch /x /opt/passafe/x || true; grep -E 'NoNewPrivs|CapEff' /proc/1/status"
    tried = deployment.host.run("podman", "exec", name, "sh", "-c", inside)

    user, *status = tried.stdout.split("\n")
    assert user == "10001"
    assert tried.stderr.count("Read-only file system") == 2
    assert status[0].split() == ["CapEff:", "0000000000000000" if process == "dashboard" else "0000000000800000"]
    assert status[1].split() == ["NoNewPrivs:", "1"]
    assert found["HostConfig"]["Memory"] == 512 * 1024**2
    published = [port for port in found["NetworkSettings"]["Ports"].values() if port]
    assert len(published) == (process == "dashboard")


def test_page_answers_on_the_published_port(deployment: Deployment) -> None:
    page = f"https://{deployment.environment['PASSAFE_PAGE']}/"
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE  # it was made when the dashboard started
    with pytest.raises(urllib.error.HTTPError, match="401"):
        urllib.request.urlopen(page, timeout=10.0, context=trusting)
    asked = urllib.request.Request(page, headers={"Authorization": f"Bearer {PAGE_TOKEN}"})
    with urllib.request.urlopen(asked, timeout=10.0, context=trusting) as answer:  # noqa: S310 - it is https
        assert answer.status == 200
        assert b"<html" in answer.read()


def test_robot_is_driven_and_its_log_is_in_the_volume(deployment: Deployment) -> None:
    time.sleep(DRIVEN_S)  # what is judged is a drive of this length
    deployment.wait_until_healthy(*PROCESSES)
    for process in reversed(PROCESSES):  # the plant first, as `docker compose stop` does
        deployment.compose("stop", process)

    [path] = deployment.logs()
    log = RunLog.read(path)
    assert log.finished
    verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))
    assert verdict.ticks > 0.9 * DRIVEN_S * RATE_HZ
    assert verdict.h_min is not None
    assert verdict.h_min >= 0
    assert {name for name, judged in verdict.properties.items() if judged.required and not judged.holds} == set()


def test_health_is_asked_of_the_loop_and_a_killed_filter_returns(deployment: Deployment) -> None:
    deployment.compose("start")
    deployment.wait_until_healthy(*PROCESSES)
    assert len(deployment.logs()) == 2  # a restarted recorder replaces no log

    os.kill(deployment.pid("plant"), signal.SIGSTOP)
    time.sleep(3.5)  # longer than the silence after which a loop counts as dead
    assert not deployment.healthy("plant")
    os.kill(deployment.pid("plant"), signal.SIGCONT)

    killed = deployment.pid("filter")
    os.kill(killed, signal.SIGKILL)
    end = time.monotonic() + PATIENCE_S
    while deployment.pid("filter") in {killed, 0}:
        assert time.monotonic() < end
        time.sleep(0.2)  # the engine says nothing of a restart that one could wait for
    deployment.wait_until_healthy(*PROCESSES)
