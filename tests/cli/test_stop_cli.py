"""``passafe stop`` and ``passafe clear`` load fast, others without SciPy; and they say in one line what is wrong."""

import subprocess
import sys

import pytest

LOADED = """
import sys
_, command, *heavy = sys.argv
sys.argv[1:] = [command, "--help"]
from passafe_services.cli.__main__ import main
try:
    main()
except SystemExit:
    print(sorted(name for name in heavy if name in sys.modules))
"""


def passafe(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-P", "-m", "passafe_services.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize(
    ("command", "heavy", "shown"),
    [("stop", ("casadi", "scipy", "mcap"), "Press the emergency stop"), ("demo", ("scipy",), "Run router, recorder")],
)
def test_a_command_does_not_wait_for_what_others_need(command: str, heavy: tuple[str, ...], shown: str) -> None:
    program = [sys.executable, "-c", LOADED, command, *heavy]
    done = subprocess.run(program, capture_output=True, text=True, timeout=60, check=True)

    assert shown in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("command", ["stop", "clear"])
def test_without_a_system_one_line_says_so(command: str) -> None:
    done = passafe(command, "--router", "127.0.0.1:9", "--insecure")

    assert done.returncode != 0
    [line] = [line for line in done.stderr.splitlines() if "insecure:" not in line]
    assert "no router answered" in line
