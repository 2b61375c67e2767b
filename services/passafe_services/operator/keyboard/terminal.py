"""Terminal of the operator: reads keys and displays one line.

The only file of the operator with side effects. Usage::

    with Terminal() as terminal:
        source = build_source(KeyboardSource(kind="keyboard"), inputs, keys=terminal.poll)
        node = OperatorNode(source, epoch=epoch, show=terminal.show)
        ...  # run the node until a signal or node.finished

Leaving the ``with`` block always restores the terminal. Signals are handled by the driver, which ends its loop on
SIGTERM and on the SIGINT that the terminal sends for Ctrl-C.
"""

import os
import select
import termios
import tty
from collections.abc import Sequence
from typing import Any, Final, Self

from passafe_services.operator.errors import TerminalError
from passafe_services.operator.keyboard.display import OperatorView, line
from passafe_services.operator.keyboard.keys import Key, KeyReader

HELP: Final = "arrows, WASD or hjkl push (yubn: diagonals)   release: fades   space: stop   x: emergency stop   q: quit"
_READ_BYTES: Final = 1024
_STANDARD_INPUT: Final = 0
_STANDARD_OUTPUT: Final = 1


class Terminal:
    """Terminal in cbreak mode within the ``with`` block: unbuffered keys without echo.

    ``poll`` and ``show`` never block: they may be called from a real-time loop.
    """

    def __init__(self, *, keys_from: int = _STANDARD_INPUT, show_on: int = _STANDARD_OUTPUT) -> None:
        """Set the descriptors; the terminal is unchanged before the ``with`` block.

        Args:
            keys_from: File descriptor of the keys.
            show_on: File descriptor of the display; without a terminal, nothing is displayed.
        """
        self._keys_from = keys_from
        self._show_on = show_on
        self._shows = os.isatty(show_on)
        self._reader = KeyReader()
        self._gone = False
        self._saved: list[Any] | None = None  # settings of termios, opaque

    def __enter__(self) -> Self:
        """Switch the terminal to cbreak mode.

        Raises:
            TerminalError: It is not a terminal, or this process runs in its background.
        """
        wanted = "an interactive terminal in the foreground"
        if not os.isatty(self._keys_from):
            raise TerminalError("an input that is no terminal", wanted)
        if self._in_background():
            # Reading keys from there would stop the whole process.
            raise TerminalError("a process in the background of its terminal", wanted)
        try:
            self._saved = termios.tcgetattr(self._keys_from)
            termios.tcsetattr(self._keys_from, termios.TCSANOW, _cbreak(self._saved))
            termios.tcflush(self._keys_from, termios.TCIFLUSH)  # earlier input is not a command
        except termios.error as error:
            self._restore()
            raise TerminalError(f"a terminal that refuses its settings ({error.args[-1]})", wanted) from error
        self._write(HELP + "\n")
        return self

    def __exit__(self, *_raised: object) -> None:
        """Restore the terminal."""
        self._restore()
        self._write("\n")

    def poll(self) -> Sequence[Key]:
        """Return the keys since the last call; ``QUIT`` once after the terminal has been closed."""
        if self._gone:
            return ()
        try:
            if not select.select([self._keys_from], [], [], 0)[0]:
                return ()
            data = os.read(self._keys_from, _READ_BYTES)
        except OSError:
            data = b""
        if not data:
            self._gone = True
            return (Key.QUIT,)
        return self._reader.feed(data)

    def show(self, view: OperatorView) -> None:
        """Replace the displayed line by ``view``, if the terminal accepts it without blocking."""
        try:
            columns = os.get_terminal_size(self._show_on).columns if self._shows else 0
        except OSError:
            self._shows = False
        else:
            # A full last column would wrap; an unknown width is taken as 80 columns.
            self._write("\r\x1b[2K" + line(view, (columns or 80) - 1))

    def _write(self, text: str) -> None:
        if not self._shows:
            return
        try:
            if select.select([], [self._show_on], [], 0)[1]:
                os.write(self._show_on, text.encode("ascii"))
        except OSError:
            self._shows = False

    def _in_background(self) -> bool:
        try:
            return os.tcgetpgrp(self._keys_from) != os.getpgrp()
        except OSError:
            return False  # not the controlling terminal of this process, so there is no background

    def _restore(self) -> None:
        if self._saved is None:
            return
        try:
            termios.tcflush(self._keys_from, termios.TCIFLUSH)  # pending repeats would go to the shell
            termios.tcsetattr(self._keys_from, termios.TCSANOW, self._saved)
        except termios.error:
            self._gone = True  # hung up: nothing to restore
        self._saved = None


def _cbreak(settings: list[Any]) -> list[Any]:
    """Return settings with unbuffered keys, without echo and without flow control by Ctrl-S."""
    changed = settings.copy()
    changed[tty.IFLAG] &= ~termios.IXON
    changed[tty.LFLAG] &= ~(termios.ECHO | termios.ICANON)
    changed[tty.CC] = settings[tty.CC].copy()
    changed[tty.CC][termios.VMIN] = 1
    changed[tty.CC][termios.VTIME] = 0
    return changed
