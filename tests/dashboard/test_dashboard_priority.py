"""The page's server comes before ordinary processes, and its jobs after them."""

import subprocess
import sys

import pytest
from passafe_dashboard.priority import NICENESS

MAY = "import os; os.setpriority(os.PRIO_PROCESS, 0, -1)"


def printed(program: str) -> int:
    """Return the number that a program prints."""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.fixture(autouse=True)
def allowed() -> None:
    if subprocess.run([sys.executable, "-c", MAY], capture_output=True, check=False).returncode:
        pytest.skip("a negative niceness is not permitted here")


def test_server_comes_before_ordinary_processes() -> None:
    serve = "from passafe_dashboard.priority import serve_before_others as go; go()"
    assert printed(f"import os; {serve}; print(os.getpriority(os.PRIO_PROCESS, 0))") == NICENESS


@pytest.mark.parametrize(("of_server", "of_job"), [(NICENESS, 5), (0, 5), (3, 8)])
def test_job_of_a_prompt_server_gives_way(of_server: int, of_job: int) -> None:
    begin = f"import os; os.setpriority(os.PRIO_PROCESS, 0, {of_server})"
    step = "from passafe_dashboard.jobs.job_process import step_back; step_back(5)"
    assert printed(f"{begin}; {step}; print(os.getpriority(os.PRIO_PROCESS, 0))") == of_job
