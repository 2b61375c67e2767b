"""The wheel with compiled modules does what the sources do, to the last bit."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = [pytest.mark.compiled, pytest.mark.timeout(900)]

ROOT = Path(__file__).parents[2]
PARTS = ("passafe", "protocol", "services", "dashboard", "wheel_build", "tests/system")
HOOKS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]
MODULES = [path.removesuffix(".py").replace("/", ".") for path in HOOKS["custom"]["modules"]]


def run(*command: str, folder: Path = ROOT, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *command],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy of what a wheel is built from, to be built without training: that takes a minute and changes no result."""
    folder = tmp_path_factory.mktemp("sources")
    for name in PARTS:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    project = (ROOT / "pyproject.toml").read_text()
    assert "\ntrained = true\n" in project
    (folder / "pyproject.toml").write_text(project.replace("\ntrained = true\n", "\ntrained = false\n"))
    return folder


@pytest.fixture(scope="module")
def installed(sources: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with what the compiled wheel installs."""
    folder = tmp_path_factory.mktemp("compiled")
    quiet = ("-m", "pip", "--quiet", "--disable-pip-version-check")
    wheel = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), ".")
    run(*quiet, *wheel, folder=sources, HATCH_BUILD_HOOK_ENABLE_CUSTOM="true")
    [built] = folder.glob("*.whl")
    run(*quiet, "install", "--no-deps", "--no-index", "--target", str(folder / "site"), str(built))
    return folder / "site"


def looked_at(path: Path) -> tuple[str, set[str]]:
    """Return what loops send, as one number, and the kinds of file that the listed modules are, as installed there."""
    found = json.loads(run("tests/system/lockstep_digest.py", *MODULES, PYTHONPATH=str(path)))
    return found["digest"], {Path(file).suffix for file in found["origins"].values()}


def test_loops_send_the_same_bytes_compiled_and_not(installed: Path) -> None:
    digest, kinds = looked_at(installed)

    assert kinds == {".so"}
    assert looked_at(ROOT) == (digest, {".py"})


UNKNOWN_PHASE = """
from passafe_protocol.checksum import sealed
from passafe_protocol.codec import decode
from passafe_protocol.errors import InvalidMessageError
from passafe_protocol.messages import SCHEMA_VERSION
from passafe_protocol.passafe_pb2 import PlantState
from passafe_protocol.topics import STATE

message = PlantState(x=[1.0], phase=9)
message.header.schema_version = SCHEMA_VERSION
message.header.source = "plant"
try:
    decode(STATE, sealed(message.SerializeToString()))
except InvalidMessageError as refusal:
    print(refusal)
"""


def test_what_a_compiled_record_cannot_hold_is_refused_as_from_the_sources(installed: Path) -> None:
    refusals = [run("-P", "-c", UNKNOWN_PHASE, PYTHONPATH=str(path)) for path in (installed, ROOT)]

    assert refusals[0] == refusals[1]
    assert "phase: got 9, allowed 1 (WAITING)" in refusals[0]


def test_nothing_compiled_is_left_beside_the_sources(installed: Path, sources: Path) -> None:
    assert list(installed.glob("passafe/*.so"))
    assert not [path for package in ("passafe", "protocol", "services") for path in (sources / package).rglob("*.so")]


def test_a_sweep_runs_in_worker_processes_from_the_wheel(installed: Path, tmp_path: Path) -> None:
    sweep = ("experiment", "random-network", "--seeds", "4", "--workers", "2", "--keep", "none", "--out", str(tmp_path))

    run(str(installed / "bin" / "passafe"), *sweep, PYTHONPATH=str(installed))

    assert (tmp_path / "cells.csv").read_text()
