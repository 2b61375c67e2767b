"""``passafe campaign`` as a process: Ctrl-C ends it at once, and the same command resumes."""

import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

NAME = "notomista-cai-2020"


def command(out: Path, *options: str) -> list[str]:
    return [sys.executable, "-P", "-m", "passafe_services.cli", "campaign", NAME, "--out", str(out), *options]


def children_cpu_s(pid: int) -> float:
    """Return the CPU time that the child processes of a process have used, s."""
    used_s = 0.0
    for child in psutil.Process(pid).children():
        with suppress(psutil.NoSuchProcess):
            used_s += child.cpu_times().user
    return used_s


@pytest.mark.live
@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_ends_a_campaign_within_its_batch(workers: str, tmp_path: Path) -> None:
    """A batch of this campaign takes minutes: whoever waited for it would not end in time."""
    out = tmp_path / "out"
    options = ["--rollouts", "2000", "--duration", "100", "--workers", workers]
    with subprocess.Popen(
        command(out, *options), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as running:
        deadline_s = time.monotonic() + 60
        while not ((out / f"{NAME}.jsonl").exists() and children_cpu_s(running.pid) > 2.0):
            assert running.poll() is None
            assert time.monotonic() < deadline_s
            time.sleep(0.02)  # another process's progress is no event that this one could wait for
        running.send_signal(signal.SIGINT)
        stdout, stderr = running.communicate(timeout=30)

    assert running.returncode == 130, stderr
    assert "Traceback" not in stderr
    assert "the same command resumes" in stdout


@pytest.mark.live
def test_the_same_command_with_more_rollouts_resumes(tmp_path: Path) -> None:
    file = tmp_path / "out" / f"{NAME}.jsonl"
    for rollouts in ("2", "5"):
        options = ["--rollouts", rollouts, "--duration", "0.1", "--workers", "1"]
        done = subprocess.run(command(file.parent, *options), capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        lines = file.read_text(encoding="utf-8").splitlines()
        assert len(lines) == 1 + int(rollouts)
    assert (file.parent / f"{NAME}.summary.json").exists()


@pytest.mark.parametrize("options", [("--duration", "1e12"), ("--rollouts", "1000000000")])
def test_a_campaign_without_an_end_is_refused(options: tuple[str, ...], tmp_path: Path) -> None:
    done = subprocess.run(command(tmp_path / "out", *options), capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 2
    assert "less than or equal to" in " ".join(done.stderr.replace("│", " ").split())
    assert not (tmp_path / "out").exists()
