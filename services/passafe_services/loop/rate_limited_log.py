"""Log of a process: lines on standard error and ``Event`` messages, limited in rate."""

import sys
from contextlib import suppress
from typing import Final

from passafe_protocol.messages import Event

PERIOD_NS: Final = 5_000_000_000
"""Shortest time between two messages of the same kind."""


class RateLimitedLog:
    """Logs a message of each kind at most once per ``PERIOD_NS`` and counts those suppressed in between."""

    def __init__(self) -> None:
        self._next_ns: dict[str, int] = {}
        self._suppressed: dict[str, int] = {}

    def report(self, kind: str, severity: str, text: str, now_ns: int) -> Event | None:
        """Log a message.

        Args:
            kind: Kind of the message; the limit applies to each kind separately.
            severity: ``info``, ``warning`` or ``error``.
            text: Text of the message.
            now_ns: Monotonic time, ns.

        Returns:
            The event to publish, or ``None`` if it was suppressed; the next event contains the number of those.
        """
        if now_ns < self._next_ns.get(kind, now_ns):
            self._suppressed[kind] = self._suppressed.get(kind, 0) + 1
            return None
        self._next_ns[kind] = now_ns + PERIOD_NS
        suppressed = self._suppressed.pop(kind, 0)
        logged = f"{text} (and {suppressed} more like it)" if suppressed else text
        with suppress(OSError):  # standard error may be closed
            sys.stderr.write(f"{severity}: {logged}\n")
            sys.stderr.flush()
        return Event(severity, logged)
