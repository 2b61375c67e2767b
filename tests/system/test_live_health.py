"""Running processes report the health of their loops."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from time import monotonic_ns

import pytest
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.loop.health_report import HealthReport
from running_demo import free_port

pytestmark = pytest.mark.live

PATIENCE_S = 60.0


def start(process: str, router: str, folder: Path) -> subprocess.Popen[bytes]:
    keys = ("--keys", str(folder / "keys"))
    options = ("--router", router, *keys, "--health-folder", str(folder), "--scenario", "moving-disk")
    return subprocess.Popen([sys.executable, "-P", "-m", "passafe_services.cli.run", process, *options])


def wait_until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)  # a file that another process writes is no event to wait for


def trouble(folder: Path, process: str) -> str | None:
    report = HealthReport.read(folder, process)
    return None if report is None else report.trouble(monotonic_ns())


def test_health_follows_router_and_loop(tmp_path: Path) -> None:
    address = f"127.0.0.1:{free_port()}"
    Deployment.create(tmp_path / "keys").issue(identities_of(["robot"]))
    router = start("router", address, tmp_path)
    plant: subprocess.Popen[bytes] | None = None
    try:
        wait_until(lambda: trouble(tmp_path, "router") == "")
        plant = start("plant", address, tmp_path)
        wait_until(lambda: trouble(tmp_path, "plant") == "")

        router.kill()
        wait_until(lambda: trouble(tmp_path, "plant") == "no router is connected")
        plant.terminate()
        assert plant.wait(PATIENCE_S) == 0
    finally:
        for child in (router, plant):
            if child is not None:
                child.kill()
                child.wait()
