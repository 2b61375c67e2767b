"""The campaign of the arm in MuJoCo, a short slice of it."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mujoco")
SCRIPT = Path(__file__).parents[2] / "benchmarks" / "arm_in_mujoco.py"


@pytest.mark.campaign
def test_two_seeds_stay_apart_from_everything() -> None:
    command = [sys.executable, str(SCRIPT), "--runs", "2", "--duration", "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)

    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 of 2 runs apart from everything" in done.stdout
