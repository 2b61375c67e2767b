"""Header of every message: sender, number and times."""

from typing import Final

from passafe_protocol.messages.record import Record

SCHEMA_VERSION: Final = 3
"""Version of ``passafe.proto``; a reader refuses every other."""

UNKNOWN_CLOCK: Final = 0
"""``clock_id`` of a sender that does not tell which clock it reads."""

VIRTUAL_CLOCK: Final = 1
"""``clock_id`` of every process of a lockstep run: they share the virtual clock."""


class Header(Record, frozen=True):
    """Sender, number and times of a message."""

    source: str
    epoch: int
    sequence: int
    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int
    clock_id: int = UNKNOWN_CLOCK
