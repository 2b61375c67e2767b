"""The checksum at the end of every message: a flipped bit never passes for another message.

The last six bytes are the protobuf field ``checksum`` (number 99, fixed32): CRC-32 as of zlib, Ethernet and PNG of all
bytes before it, little-endian. Any protobuf reader sees it as one more number, so logs stay readable as they are, and
anybody can check it from the log alone. It finds every error of one bit, of two, and every burst of up to 32 bits.
"""

from typing import Final
from zlib import crc32

FIELD_NUMBER: Final = 99
_FIXED32: Final = 5
_KEY_VALUE: Final = FIELD_NUMBER << 3 | _FIXED32
KEY: Final = bytes((_KEY_VALUE & 0x7F | 0x80, _KEY_VALUE >> 7))
"""Protobuf's key of the field: number and wire type as a varint."""

SEAL_BYTES: Final = len(KEY) + 4


def sealed(data: bytes) -> bytes:
    """The bytes of a message with their checksum after them."""
    return data + KEY + crc32(data).to_bytes(4, "little")


def is_intact(data: bytes) -> bool:
    """Tell whether bytes end with the checksum of what stands before it."""
    end = len(data) - SEAL_BYTES
    return end >= 0 and data[end:] == KEY + crc32(memoryview(data)[:end]).to_bytes(4, "little")
