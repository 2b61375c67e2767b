"""Wait for who drives a running system, as its bus has it."""

import time
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.messages import OperatorLease
from passafe_protocol.topics import LEASE
from passafe_services.loop.bus import Bus

PATIENCE_S: Final = 60.0


def wait_for_driver(bus: Bus, device: str) -> None:
    """Wait until a device holds the filter's lease."""
    leases = bus.reader(LEASE)
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        for _, body in (decode(LEASE, data) for data in leases.drain()):
            if isinstance(body, OperatorLease) and body.device == device:
                return
        time.sleep(0.005)  # readers are polled
    raise AssertionError(f"{device} did not drive within {PATIENCE_S:g} s")
