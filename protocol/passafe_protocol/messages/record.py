"""Base of every record, and the type of its vectors."""

from typing import TypeAlias

from msgspec import Struct

Vector: TypeAlias = tuple[float, ...]


class Record(Struct, frozen=True, gc=False):
    """Base of all records; at a dozen per tick, a frozen dataclass would cost ten times as much (decision 0003).

    Records hold numbers, text and other records, never a cycle, so garbage collection is disabled for them.
    """
