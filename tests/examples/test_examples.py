"""The example scripts run as a newcomer would run them."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MOST_LINES = 60


def _run(*words: str, cwd: Path) -> str:
    command = [sys.executable, str(ROOT / "examples" / words[0]), *words[1:]]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.name)
def test_example_is_short_and_explained(script: Path) -> None:
    text = script.read_text(encoding="utf-8")

    assert len(text.splitlines()) < MOST_LINES
    assert ast.get_docstring(ast.parse(text))
    assert text.count("# ") >= 3


def test_there_is_an_example_for_each_purpose() -> None:
    assert len(EXAMPLES) >= 5


def test_library_filter_keeps_the_cart_off_the_buffer(tmp_path: Path) -> None:
    last = _run("library_filter.py", cwd=tmp_path).splitlines()[-1]

    furthest = float(last.split()[2])
    assert 0.9 < furthest <= 1.0


def test_own_barrier_modifies_the_command(tmp_path: Path) -> None:
    out = _run("own_barrier.py", cwd=tmp_path)

    assert out.startswith("relative degree 1")
    assert "MODIFIED" in out


def test_log_to_pandas_reads_a_simulated_run(tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "simulate", "--duration", "0.5", "--out", "run.mcap"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=120)

    out = _run("log_to_pandas.py", "run.mcap", cwd=tmp_path)

    assert "mode both" in out
    assert "MODIFIED" in out


def test_delay_experiment_shows_what_prediction_is_worth(tmp_path: Path) -> None:
    table = _run("delay_experiment.py", "delay", cwd=tmp_path).splitlines()[-3:]

    _, blind, predicting = table[-1].split()
    assert float(blind) < 0.0 <= float(predicting)
