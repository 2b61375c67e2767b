"""The wheel with compiled modules does what the sources do, to the last bit."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = [pytest.mark.compiled, pytest.mark.timeout(900)]  # a loaded machine compiles slowly

ROOT = Path(__file__).parents[2]
PARTS = ("passafe", "protocol", "services", "dashboard", "wheel_build")
FILES = ("pyproject.toml", "README.md", "LICENSE")
HOOKS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]
MODULES = [path.removesuffix(".py").replace("/", ".") for path in HOOKS["custom"]["modules"]]
SOURCES = os.pathsep.join(str(ROOT / folder) for folder in ("", "protocol", "services", "dashboard"))


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
    """Copy of what a wheel is built from."""
    folder = tmp_path_factory.mktemp("sources")
    for name in PARTS:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
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


def digest_and_kinds(path: str) -> tuple[str, set[str]]:
    """Return a digest of what loops send, and the kinds of file that the listed modules are, as imported from there."""
    found = json.loads(run("tests/system/lockstep_digest.py", *MODULES, PYTHONPATH=path))
    return found["digest"], {Path(file).suffix for file in found["origins"].values()}


def test_loops_send_the_same_bytes_compiled_and_not(installed: Path) -> None:
    digest, kinds = digest_and_kinds(str(installed))

    assert kinds == {".so"}
    assert digest_and_kinds(SOURCES) == (digest, {".py"})


def test_nothing_compiled_is_left_beside_the_sources(installed: Path, sources: Path) -> None:
    assert list(installed.glob("passafe/*.so"))
    assert not [path for package in ("passafe", "protocol", "services") for path in (sources / package).rglob("*.so")]


def test_compiled_sweep_runs_in_worker_processes(installed: Path, tmp_path: Path) -> None:
    sweep = ("experiment", "random-network", "--seeds", "4", "--workers", "2", "--keep", "none", "--out", str(tmp_path))

    run(str(installed / "bin" / "passafe"), *sweep, PYTHONPATH=str(installed))

    assert (tmp_path / "cells.csv").read_text()
