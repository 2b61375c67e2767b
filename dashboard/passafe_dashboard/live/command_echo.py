"""Echo the newest command of an operator, from which it learns how old what a page sends is."""

from dataclasses import replace
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.topics import COMMAND
from passafe_services.loop.bus import Bus

QUEUE: Final = 8


class CommandEcho:
    """Reader of the operators' commands, of which it keeps the newest.

    Args:
        bus: The session.
    """

    def __init__(self, bus: Bus) -> None:
        self._reader = bus.reader(replace(COMMAND, queue=QUEUE))
        self._epoch, self._scheduled_ns, self._arrived_ns = 0, 0, 0

    def newest(self, now_ns: int) -> tuple[int, int, int]:
        """Return session, ``scheduled_ns`` and time since the arrival, ns; session 0 before the first command.

        Args:
            now_ns: Monotonic time.
        """
        arrived = self._reader.drain()
        if arrived:
            try:
                header, _ = decode(COMMAND, arrived[-1])
            except ProtocolError:
                pass  # the filter, whom it is for, reports it
            else:
                self._epoch, self._scheduled_ns, self._arrived_ns = header.epoch, header.scheduled_ns, now_ns
        return self._epoch, self._scheduled_ns, now_ns - self._arrived_ns if self._epoch else 0
