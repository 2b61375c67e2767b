"""One supervised process: its output, its readiness and its exit."""

import asyncio
import os
import signal
import socket
from asyncio.subprocess import PIPE
from collections.abc import Callable, Sequence
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import Final, cast

from passafe_services.loop.process_exit import Exit
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.readiness import ready_line

LONGEST_LINE_BYTES: Final = 65_536
"""Longest line relayed as one; longer ones are split."""

STARTUP_NICENESS: Final = -15
"""Niceness during startup: some thirty times the share of an ordinary process, still behind real-time loops. On two
processors with a dozen busy processes a start took 1.0 s instead of 6.2 s."""

_LAST_LINES_S: Final = 0.5
"""Time to wait for the last lines of a process that has ended: another process may hold its pipes."""

_STANDARD_OUTPUT: Final = 1
_STANDARD_ERROR: Final = 2

RelayLine = Callable[[str, str], None]


class Intent(Enum):
    """Future of a child once it has ended."""

    RUN = "run"
    """It was to run on: its restart policy decides."""

    STAY_DOWN = "stay down"
    """It was killed on request, and waits for a request to start again."""

    RESTART = "restart"
    """It is started again on request, whatever its restart policy says."""


class ChildProcess(asyncio.SubprocessProtocol):
    """Process in a session of its own, so that Ctrl-C in a terminal reaches the supervisor alone.

    Its standard input is a lifeline that closes when the supervisor ends, even if it is killed.

    Attributes:
        spec: Its specification.
        ready: Set when it has reported that it is ready.
        ended: Done when it has ended and its last lines are relayed; holds its return code.
        restarted: Whether another child was started in its place after its end.
        intent: What is to become of it once it has ended.
        options: Options, beside those of its specification, of the one that is started in its place.
        control: This end of its control channel; ``None`` if its specification has no option for one.
        on_ready: Called when it has reported that it is ready.
    """

    def __init__(self, spec: ProcessSpec, relay: RelayLine, loop: asyncio.AbstractEventLoop) -> None:
        self.spec = spec
        self.ready = asyncio.Event()
        self.ended: asyncio.Future[int] = loop.create_future()
        self.restarted = False
        self.intent = Intent.RUN
        self.options: tuple[str, ...] = ()
        self.on_ready: Callable[[], None] = lambda: None
        self.control: socket.socket | None = None
        self._relay = relay
        self._loop = loop
        self._transport: asyncio.SubprocessTransport | None = None
        self._unfinished = {_STANDARD_OUTPUT: b"", _STANDARD_ERROR: b""}  # last line of each open pipe
        self._stop_requested = False
        self._killed = False
        self._prioritized = False

    @classmethod
    async def start(
        cls, spec: ProcessSpec, relay: RelayLine, *, epoch: int = 0, options: Sequence[str] = ()
    ) -> "ChildProcess":
        """Start a process.

        Args:
            spec: The process.
            relay: Called with its name and each line that it prints.
            epoch: Epoch of its session.
            options: Options beside those of its specification.

        Raises:
            OSError: The process cannot be started.
        """
        loop = asyncio.get_running_loop()
        child = cls(spec, relay, loop)
        command = (*spec.command(epoch), *options)
        if not spec.control_option:
            await child._execute(command)
            return child
        child.control, other_end = socket.socketpair()
        with other_end:
            channel = other_end.fileno()
            try:
                await child._execute((*command, spec.control_option, str(channel)), (channel,))
            except BaseException:
                child.control.close()
                raise
        return child

    async def _execute(self, command: tuple[str, ...], channels: tuple[int, ...] = ()) -> None:
        await self._loop.subprocess_exec(
            lambda: self, *command, stdin=PIPE, stdout=PIPE, stderr=PIPE, start_new_session=True, pass_fds=channels
        )

    @property
    def running(self) -> bool:
        """True until it has ended."""
        return self._transport is not None and self._transport.get_returncode() is None

    @property
    def exit(self) -> Exit:
        """Exit of the process; only after ``ended``."""
        return Exit(
            name=self.spec.name,
            returncode=self.ended.result(),
            requested=self._stop_requested,
            killed=self._killed,
            restarted=self.restarted,
            ready=self.ready.is_set(),
            ended_on_request=self.intent is not Intent.RUN,
        )

    def prioritize_startup(self) -> None:
        """Run it with ``STARTUP_NICENESS`` until it is ready."""
        self._prioritized = True
        self._set_niceness(STARTUP_NICENESS, STARTUP_NICENESS)

    def terminate(self) -> None:
        """Request its end (SIGTERM)."""
        if self.running and self._transport is not None:
            self._stop_requested = True
            with suppress(ProcessLookupError):
                self._transport.terminate()

    def kill(self) -> None:
        """Kill it and its own children (SIGKILL to its process group)."""
        if self.running:
            self._stop_requested = self._killed = True
            self._kill_group()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport of the started process (called by asyncio)."""
        self._transport = cast("asyncio.SubprocessTransport", transport)

    def pipe_data_received(self, fd: int, data: bytes) -> None:
        """Relay the lines that it printed (called by asyncio)."""
        *lines, rest = (self._unfinished[fd] + data).split(b"\n")
        if len(rest) > LONGEST_LINE_BYTES:
            lines.append(rest)
            rest = b""
        self._unfinished[fd] = rest
        for line in lines:
            self._receive_line(line)

    def pipe_connection_lost(self, fd: int, exc: Exception | None) -> None:
        """Relay an unfinished last line (called by asyncio); standard input may close at any time."""
        del exc
        rest = self._unfinished.pop(fd, b"")
        if rest:
            self._receive_line(rest)
        if not self.running and not self._unfinished:
            self._end()

    def process_exited(self) -> None:
        """End its process group (called by asyncio), possibly long before its pipes close."""
        self._kill_group()  # its children must not outlive it
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
        # The group has the pid of the process, which is not reused while the group has members.
        if self._transport is not None:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._transport.get_pid(), signal.SIGKILL)

    def _set_niceness(self, niceness: int, of_session: int) -> None:
        if self._transport is None:
            return
        pid = self._transport.get_pid()
        # With autogroup scheduling, niceness applies within a session's group, and the group has a niceness of its own.
        with suppress(OSError):  # not permitted or not supported: default scheduling remains
            os.setpriority(os.PRIO_PROCESS, pid, niceness)
            Path(f"/proc/{pid}/autogroup").write_text(str(of_session), encoding="ascii")

    def _has_startup_niceness(self) -> bool:
        """Return whether it still has the niceness of its startup, and has not chosen one of its own."""
        if self._transport is None:
            return False
        try:
            return os.getpriority(os.PRIO_PROCESS, self._transport.get_pid()) == STARTUP_NICENESS
        except OSError:  # it has ended
            return False

    def _receive_line(self, line: bytes) -> None:
        text = line.decode(errors="replace").rstrip("\r")
        if text == ready_line(self.spec.name):
            self.ready.set()
            self.on_ready()
            if self._prioritized and self._has_startup_niceness():
                self._set_niceness(os.getpriority(os.PRIO_PROCESS, 0), 0)
        else:
            self._relay(self.spec.name, text)
