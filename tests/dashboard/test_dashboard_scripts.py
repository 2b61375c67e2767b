"""The scripts of the pages: their unit tests, and their types."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TESTS = ROOT / "tests" / "dashboard" / "scripts"
LEAST_NODE = 18
"""First version whose test runner reports failures by its exit code."""


def node() -> str:
    """Return the path of Node.js; the test is skipped where there is none that can run tests."""
    found = shutil.which("node")
    if found is None:
        pytest.skip("Node.js is not installed")
    version = subprocess.run([found, "--version"], capture_output=True, text=True, check=True).stdout
    if int(version.removeprefix("v").split(".")[0]) < LEAST_NODE:
        pytest.skip(f"Node.js {version.strip()} is older than {LEAST_NODE}")
    return found


def test_unit_tests_of_the_scripts_pass() -> None:
    files = sorted(map(str, TESTS.glob("*.test.mjs")))
    assert files
    done = subprocess.run([node(), "--test", *files], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout


def test_types_of_the_scripts_are_right() -> None:
    tsc = shutil.which("tsc") or shutil.which("tsc", path=str(ROOT / "dashboard" / "node_modules" / ".bin"))
    if tsc is None:
        pytest.skip("the TypeScript compiler is not installed: npm install, in the folder dashboard")
    command = [node(), str(Path(tsc).resolve()), "--project", str(ROOT / "dashboard" / "jsconfig.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT / "dashboard")
    assert done.returncode == 0, done.stdout + done.stderr
