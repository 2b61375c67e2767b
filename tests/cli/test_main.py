"""Start of the command line."""

import subprocess
import sys

SWALLOWING = """
import os, signal
import passafe_services.cli.__main__ as command_line

def load():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        signal.sigtimedwait([], 0.1)
    except KeyboardInterrupt:
        pass  # as the import system does in its callbacks
    print("went on")

command_line._run_commands = load
command_line.main()
"""


def test_no_interrupt_is_lost_while_modules_are_loaded() -> None:
    done = subprocess.run([sys.executable, "-c", SWALLOWING], capture_output=True, text=True, check=False)

    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")
