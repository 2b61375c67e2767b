"""A slice of the campaign of kills, truncations and corruptions, by seed; ``make recovery`` runs all of it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGN = Path(__file__).with_name("recovery_campaign.py")


def run(**rounds: int) -> dict[str, object]:
    options = [text for name, number in rounds.items() for text in (f"--{name}", str(number))]
    done = subprocess.run([sys.executable, str(CAMPAIGN), *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    result: dict[str, object] = json.loads(done.stdout)
    return result


def test_damaged_logs_are_recovered_or_named() -> None:
    result = run(kills=0, truncations=6, corruptions=14, seed=100)
    assert (result["rounds"], result["broken"]) == ({"truncation": 6, "corruption": 14}, [])


@pytest.mark.live
def test_killed_recorders_lose_what_is_promised() -> None:
    result = run(kills=3, truncations=0, corruptions=0, seed=100)
    assert (result["rounds"], result["broken"]) == ({"kill": 3}, [])
