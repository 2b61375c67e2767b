"""End of a process that publishes: it waits until the recorder has its last messages.

What the recorder missed it can have again from the cache of its publisher, which ends with the process.
"""

import time
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Receipt
from passafe_protocol.topics import RECEIPT

from passafe_services.loop.bus import Bus
from passafe_services.loop.outlet import Outlet

WAIT_S: Final = 4.0
"""Longest wait: less than the grace of a process whose lifeline has ended."""

SILENCE_S: Final = 2.5
"""Time without a receipt after which there is no recorder any more: longer than a loaded machine makes it pause."""

_POLL_S: Final = 0.005


class Receipts:
    """Reader of what the recorder says that it has, from the creation of this object on."""

    def __init__(self, bus: Bus) -> None:
        self._reader = bus.reader(RECEIPT)

    def wait_for(self, outlet: Outlet) -> int:
        """Wait until the recorder has the last message of each topic; return the number of topics still missing.

        Returns at once if no receipt was received before, else within ``WAIT_S``.

        Args:
            outlet: What the process has published.
        """
        missing = {(outlet.source, topic, outlet.epoch): newest for topic, newest in outlet.newest_recorded().items()}
        begun_s = received_s = time.monotonic()
        receipt = self._newest()
        if receipt is None:
            return 0
        while True:
            if receipt is not None:
                received_s = time.monotonic()
                for session in receipt.sessions:
                    key = (session.source, session.topic, session.epoch)
                    if missing.get(key, session.newest + 1) <= session.newest:
                        del missing[key]
            now_s = time.monotonic()
            if not missing or now_s - begun_s > WAIT_S or now_s - received_s > SILENCE_S:
                return len(missing)
            time.sleep(_POLL_S)
            receipt = self._newest()

    def _newest(self) -> Receipt | None:
        """Return the newest receipt since the last call."""
        for data in self._reader.drain():
            try:
                _, receipt = decode(RECEIPT, data)
            except ProtocolError:
                continue  # damaged or of another version: the next one comes soon
            if isinstance(receipt, Receipt):
                return receipt
        return None
