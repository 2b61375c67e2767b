"""Newest operator command that counts: one that was not stale when it arrived."""

from enum import Enum
from typing import Final

from msgspec.structs import replace
from passafe_protocol.messages import CommandState, OperatorCommand, Received

from passafe_services.filter.send_time import SendTime


class Reception(Enum):
    """Consequence of a newer command for the filter."""

    COUNTS = "counts"
    """It is in force."""

    RESUMES = "resumes"
    """It is the first to be in force after a stale stretch."""

    BEGINS = "begins"
    """It is the first to be in force of another sender, or after an emergency stop."""

    LATE = "late"
    """It was stale when it arrived and does not count."""

    @property
    def ramps_in(self) -> bool:
        """True if the request ramps in with it."""
        return self is _RESUMES or self is _BEGINS


# Members by names of their own: to hash one, or to reach it through its class, takes as long as a call.
_RESUMES: Final = Reception.RESUMES
_BEGINS: Final = Reception.BEGINS
_IN_FORCE: Final = Reception.COUNTS
_COUNTS: Final = CommandState.COUNTS


class NewestCommand:
    """Keeps the newest command that counts, and the age of the newest that came.

    The age of a command includes its time on the way. A command that is stale when it arrives does not count, except
    that a released dead-man switch always ends one that does.

    Attributes:
        body: The newest command that counts, or ``None`` before the first.
        order: Epoch and sequence number of the newest command that came.
        expires_ns: Monotonic time after which ``body`` is stale, ns.
    """

    def __init__(self, send_time: SendTime, stale_ns: int) -> None:
        """Start with nothing received.

        Args:
            send_time: Estimates when commands were sent.
            stale_ns: Age above which a command is stale, ns.
        """
        self._send_time = send_time
        self._stale_ns = stale_ns
        self.restart()

    def restart(self) -> None:
        """Discard all commands."""
        self._send_time.restart()
        self.body: OperatorCommand | None = None
        self.order = (-1, -1)
        self.expires_ns = 0
        self._sent_ns: int | None = None
        self._is_late = False
        self._begins = False

    def begin_session(self) -> None:
        """Begin with the commands of another sender, of whatever epoch; the last one before fades."""
        self._send_time.restart()
        if self._sent_ns is not None:
            self._begins = True
        self.order = (-1, -1)

    def release(self) -> None:
        """Let the command in force count as released: what it asked for is void."""
        if self.body is not None:
            self.body = replace(self.body, enabled=False)

    def begin(self) -> None:
        """Let the next enabled command that counts be the first of a beginning."""
        self._begins = True

    def receive(self, received: Received, command: OperatorCommand) -> Reception:
        """Receive a command.

        Args:
            received: The message, newer than all before.
            command: Its body.
        """
        was_missed = self._is_late if self.body is None else received.received_ns > self.expires_ns
        header, sent_ns = received.header, self._send_time.of(received)
        self.order, self._sent_ns = (header.epoch, header.sequence), sent_ns
        self._is_late = not self.is_recent(received.received_ns - sent_ns)
        if self._is_late and (command.enabled or self.body is None):
            return Reception.LATE
        self.body, self.expires_ns = command, sent_ns + self._stale_ns
        if self._is_late:
            return Reception.LATE
        if self._begins and command.enabled:
            self._begins = False
            return _BEGINS
        return _RESUMES if was_missed else _IN_FORCE

    def is_recent(self, delay_ns: int) -> bool:
        """Check that a command is not stale already when it arrives so long after it was sent, ns."""
        return delay_ns <= self._stale_ns

    def age_ns(self, now_ns: int) -> int:
        """Return the age of the newest command that came, ns; −1 before the first.

        Args:
            now_ns: Monotonic time, ns.
        """
        return -1 if self._sent_ns is None else max(now_ns - self._sent_ns, 0)

    def state(self, now_ns: int) -> CommandState:
        """Return whether the command counts, and otherwise why not; a ramp is not considered.

        Args:
            now_ns: Monotonic time, ns.
        """
        if self._sent_ns is None:
            return CommandState.NONE
        if self.body is None or now_ns > self.expires_ns:
            return CommandState.DELAYED if self._is_late else CommandState.SILENT
        return _COUNTS if self.body.enabled else CommandState.RELEASED
