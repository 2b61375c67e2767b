"""The terminal as a device, on real pseudo-terminals: bytes in, line out, settings given back."""

import os
import pty
import select
import signal
import subprocess
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from passafe_services.operator.errors import TerminalError
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.keyboard.terminal import HELP, Terminal

VIEW = OperatorView(u_h=(1.0, 2.0), enabled=True, holder="", stop_source="", position=None, status=None, nearest=None)
ROOT = Path(__file__).parents[2]
LIMIT_S = 20.0


class Screen:
    """The other end of a terminal: a person's hands and eyes."""

    def __init__(self) -> None:
        self.far, self.near = pty.openpty()
        self.seen = b""

    def type(self, data: bytes) -> None:
        """Type, and return once the near end can read it."""
        os.write(self.far, data)
        assert select.select([self.near], [], [], LIMIT_S)[0]

    def read_until(self, wanted: bytes) -> bytes:
        """Return everything seen so far, once ``wanted`` is in it."""
        while wanted not in self.seen:
            assert select.select([self.far], [], [], LIMIT_S)[0], self.seen
            self.seen += os.read(self.far, 4096)
        return self.seen

    def settings(self) -> list[object]:
        """Return the terminal's settings."""
        return termios.tcgetattr(self.near)

    def local_flags(self) -> int:
        """Return those of the settings that cbreak changes."""
        return int(termios.tcgetattr(self.near)[tty.LFLAG])


@pytest.fixture
def screen() -> Iterator[Screen]:
    screen = Screen()
    yield screen
    for descriptor in (screen.far, screen.near):
        with suppress(OSError):  # a test may have hung up
            os.close(descriptor)


def test_keys_come_at_once_and_unechoed(screen: Screen) -> None:
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        assert terminal.poll() == ()
        screen.type(b"\x1b[A\x1bOCw ")
        assert list(terminal.poll()) == [Key.UP, Key.RIGHT, Key.UP, Key.STOP]
        assert terminal.poll() == ()
        screen.type(b"q")
        assert list(terminal.poll()) == [Key.QUIT]
        terminal.show(VIEW)
        seen = screen.read_until(b"filter ?")
        assert seen == HELP.encode() + b"\r\n\r\x1b[2KHELD      u_h (  +1.00,   +2.00)  robot ?  filter ?"


def test_an_arrow_torn_between_two_reads_is_one_arrow(screen: Screen) -> None:
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        screen.type(b"\x1b[")
        assert list(terminal.poll()) == []
        screen.type(b"D")
        assert list(terminal.poll()) == [Key.LEFT]


def test_settings_are_given_back(screen: Screen) -> None:
    before = screen.settings()
    with Terminal(keys_from=screen.near, show_on=screen.near):
        assert not screen.local_flags() & (termios.ECHO | termios.ICANON)
        assert screen.local_flags() & termios.ISIG
    assert screen.settings() == before


def test_settings_are_given_back_after_an_error(screen: Screen) -> None:
    before = screen.settings()
    with pytest.raises(KeyboardInterrupt), Terminal(keys_from=screen.near, show_on=screen.near):
        raise KeyboardInterrupt
    assert screen.settings() == before


def test_keys_before_and_after_the_session_are_discarded(screen: Screen) -> None:
    tty.setcbreak(screen.near, termios.TCSANOW)
    screen.type(b"www")
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        assert terminal.poll() == ()
        screen.type(b"ddd")
    assert select.select([screen.near], [], [], 0)[0] == []


def test_what_is_no_terminal_is_refused_in_one_line() -> None:
    reader, writer = os.pipe()
    try:
        with (
            pytest.raises(TerminalError, match="no terminal") as caught,
            Terminal(keys_from=reader, show_on=writer),
        ):
            pass
    finally:
        os.close(reader)
        os.close(writer)
    assert "\n" not in str(caught.value)


def test_nothing_is_shown_on_what_is_no_terminal(screen: Screen) -> None:
    reader, writer = os.pipe()
    try:
        with Terminal(keys_from=screen.near, show_on=writer) as terminal:
            terminal.show(VIEW)
        assert select.select([reader], [], [], 0)[0] == []
    finally:
        os.close(reader)
        os.close(writer)


def test_a_line_is_cut_to_the_width_of_the_terminal(screen: Screen) -> None:
    termios.tcsetwinsize(screen.near, (24, 20))
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        screen.read_until(b"quit\r\n")
        terminal.show(VIEW)
        assert screen.read_until(b"HELD      u_h (  +1").endswith(b"\r\x1b[2KHELD      u_h (  +1")
    assert screen.read_until(b"+1\r\n").endswith(b"+1\r\n")


def test_blocked_terminal_does_not_block_the_loop(screen: Screen) -> None:
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        for _ in range(2000):  # far more than a terminal nobody reads can take
            terminal.show(VIEW)
        screen.type(b"w")
        assert list(terminal.poll()) == [Key.UP]


def test_a_terminal_that_went_away_ends_the_session(screen: Screen) -> None:
    with Terminal(keys_from=screen.near, show_on=screen.near) as terminal:
        os.close(screen.far)
        assert list(terminal.poll()) == [Key.QUIT]
        assert terminal.poll() == ()
        terminal.show(VIEW)


# A process as the driver makes it: SIGTERM and Ctrl-C become an ordinary end of the loop.
DRIVER = """
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.keyboard.terminal import Terminal
from passafe_services.loop.stop import stop_requests

view = OperatorView((0.0, 0.0), False, "", "", None, None, None)
with stop_requests(lifeline=False) as stop, Terminal() as terminal:
    terminal.show(view)
    while not stop.wait(0.005):
        if Key.QUIT in terminal.poll():
            break
"""


def start(screen: Screen, program: str) -> subprocess.Popen[bytes]:
    """Start a program on the terminal, as the leader of a session that the terminal controls."""
    take_control = "import fcntl, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0)\n"
    return subprocess.Popen(
        [sys.executable, "-c", take_control + program],
        stdin=screen.near,
        stdout=screen.near,
        stderr=subprocess.PIPE,
        cwd=ROOT,
        start_new_session=True,
    )


@pytest.mark.parametrize("ending", ["q", "ctrl-c", "SIGTERM"])
def test_a_process_gives_its_terminal_back_however_it_ends(screen: Screen, ending: str) -> None:
    before = screen.settings()
    process = start(screen, DRIVER)
    try:
        screen.read_until(b"released")
        during = screen.settings()
        if ending == "SIGTERM":
            process.send_signal(signal.SIGTERM)
        else:
            os.write(screen.far, b"q" if ending == "q" else b"\x03")
        _, errors = process.communicate(timeout=LIMIT_S)
    finally:
        process.kill()
        process.communicate()
    assert (process.returncode, errors) == (0, b"")
    assert during != before
    assert screen.settings() == before


# The same terminal asked for by a process in its background, which the system would stop for reading.
BACKGROUND = """
import os, sys
from passafe_services.operator.errors import TerminalError
from passafe_services.operator.keyboard.terminal import Terminal

child = os.fork()
if child:
    _, status = os.waitpid(child, 0)
    sys.exit(os.waitstatus_to_exitcode(status))
os.setpgid(0, 0)
try:
    with Terminal():
        os._exit(1)
except TerminalError as error:
    print(error, file=sys.stderr, flush=True)
    os._exit(7)
"""


def test_background_process_is_refused_instead_of_stopped(screen: Screen) -> None:
    before = screen.settings()
    process = start(screen, BACKGROUND)
    try:
        _, errors = process.communicate(timeout=LIMIT_S)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 7
    assert errors.count(b"\n") == 1
    assert b"background" in errors
    assert screen.settings() == before
