"""One supervised process: its lines, its readiness, its end."""

import asyncio
import os
import signal
from asyncio.subprocess import PIPE
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final, cast

from passafe_services.loop.process_exit import Exit, ProcessSpec
from passafe_services.loop.readiness import ready_line

LONGEST_LINE_BYTES: Final = 65_536
"""A longer line is relayed in pieces."""

HURRY_NICENESS: Final = -15
"""Some thirty times the share of an ordinary process; real-time loops still go first. On two processors with a
dozen busy processes a start took 1.0 s instead of 6.2 s."""

_LAST_LINES_S: Final = 0.5
"""How long to wait for the last lines of a process that has ended: another may hold its pipes."""

_STANDARD_OUTPUT: Final = 1
_STANDARD_ERROR: Final = 2

Emit = Callable[[str, str], None]


class Child(asyncio.SubprocessProtocol):
    """A process in a session of its own, so that Ctrl-C in a terminal reaches the supervisor alone.

    Its standard input is a lifeline: it ends when the supervisor does, also when that is killed.

    Attributes:
        spec: What it is.
        ready: Set when it has said that it is ready.
        ended: Done when it has ended and its last lines are relayed; holds its return code.
        restarted: Whether it was started again after its end, as another child.
    """

    def __init__(self, spec: ProcessSpec, emit: Emit, loop: asyncio.AbstractEventLoop) -> None:
        self.spec = spec
        self.ready = asyncio.Event()
        self.ended: asyncio.Future[int] = loop.create_future()
        self.restarted = False
        self._emit = emit
        self._loop = loop
        self._transport: asyncio.SubprocessTransport | None = None
        self._unfinished = {_STANDARD_OUTPUT: b"", _STANDARD_ERROR: b""}  # last line of each open pipe
        self._asked = False
        self._forced = False
        self._hurries = False

    @classmethod
    async def start(cls, spec: ProcessSpec, emit: Emit) -> "Child":
        """Start a process.

        Args:
            spec: What to start.
            emit: Takes its lines: name, line.

        Raises:
            OSError: If it cannot be started.
        """
        loop = asyncio.get_running_loop()
        child = cls(spec, emit, loop)
        await loop.subprocess_exec(
            lambda: child, *spec.argv, stdin=PIPE, stdout=PIPE, stderr=PIPE, start_new_session=True
        )
        return child

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self._transport is not None and self._transport.get_returncode() is None

    @property
    def exit(self) -> Exit:
        """How it ended; only after ``ended``."""
        return Exit(
            name=self.spec.name,
            returncode=self.ended.result(),
            asked=self._asked,
            forced=self._forced,
            restarted=self.restarted,
            ready=self.ready.is_set(),
        )

    def hurry(self) -> None:
        """Let it set itself up before whatever else runs here at no real-time priority: somebody waits for it."""
        self._hurries = True
        self._set_niceness(HURRY_NICENESS, HURRY_NICENESS)

    def ask(self) -> None:
        """Ask it to end (SIGTERM)."""
        if self.running and self._transport is not None:
            self._asked = True
            with suppress(ProcessLookupError):
                self._transport.terminate()

    def kill(self) -> None:
        """End it and whatever it started (SIGKILL to its process group)."""
        if self.running:
            self._asked = self._forced = True
            self._kill_group()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Asyncio has started it."""
        self._transport = cast("asyncio.SubprocessTransport", transport)

    def pipe_data_received(self, fd: int, data: bytes) -> None:
        """Asyncio has read what it printed."""
        *lines, rest = (self._unfinished[fd] + data).split(b"\n")
        if len(rest) > LONGEST_LINE_BYTES:
            lines.append(rest)
            rest = b""
        self._unfinished[fd] = rest
        for line in lines:
            self._take(line)

    def pipe_connection_lost(self, fd: int, exc: Exception | None) -> None:
        """Asyncio found one of its pipes closed; standard input may close at any time."""
        del exc
        rest = self._unfinished.pop(fd, b"")
        if rest:
            self._take(rest)
        if not self.running and not self._unfinished:
            self._end()

    def process_exited(self) -> None:
        """Asyncio noticed its end; that may be long before its pipes close."""
        self._kill_group()  # what it started must not outlive it
        if self._unfinished:
            self._loop.call_later(_LAST_LINES_S, self._end)
        else:
            self._end()

    def _end(self) -> None:
        if self.ended.done() or self._transport is None:
            return
        self.ended.set_result(self._transport.get_returncode() or 0)
        self._transport.close()

    def _kill_group(self) -> None:
        # Its group has the number of the process, which is not given out again while the group has members.
        if self._transport is not None:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._transport.get_pid(), signal.SIGKILL)

    def _set_niceness(self, niceness: int, of_session: int) -> None:
        if self._transport is None:
            return
        pid = self._transport.get_pid()
        # Where the kernel groups processes by session, niceness counts within a group, and the group has its own.
        with suppress(OSError):  # not permitted, or not known here: then it takes its turn with the others
            os.setpriority(os.PRIO_PROCESS, pid, niceness)
            Path(f"/proc/{pid}/autogroup").write_text(str(of_session), encoding="ascii")

    def _take(self, line: bytes) -> None:
        text = line.decode(errors="replace").rstrip("\r")
        if text == ready_line(self.spec.name):
            self.ready.set()
            if self._hurries:
                self._set_niceness(os.getpriority(os.PRIO_PROCESS, 0), 0)
        else:
            self._emit(self.spec.name, text)
