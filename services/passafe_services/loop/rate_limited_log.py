"""What a process says in words: a line on standard error, and an ``Event`` to publish."""

import sys
from contextlib import suppress
from typing import Final

from passafe_protocol.messages import Event

PERIOD_NS: Final = 5_000_000_000
"""The same kind of notice is given at most once in so long."""


class RateLimitedLog:
    """Says things once, then counts until it may say them again."""

    def __init__(self) -> None:
        self._next_ns: dict[str, int] = {}
        self._untold: dict[str, int] = {}

    def notice(self, kind: str, severity: str, text: str, now_ns: int) -> Event | None:
        """Say something.

        Args:
            kind: What kind of thing it is; each kind has a limit of its own.
            severity: ``info``, ``warning`` or ``error``.
            text: What to say.
            now_ns: Monotonic time, ns.

        Returns:
            The event to publish, or ``None`` if the limit held it back; the next one tells how many were.
        """
        if now_ns < self._next_ns.get(kind, now_ns):
            self._untold[kind] = self._untold.get(kind, 0) + 1
            return None
        self._next_ns[kind] = now_ns + PERIOD_NS
        untold = self._untold.pop(kind, 0)
        told = f"{text} (and {untold} more like it)" if untold else text
        with suppress(OSError):  # nobody is left to read it
            sys.stderr.write(f"{severity}: {told}\n")
            sys.stderr.flush()
        return Event(severity, told)
