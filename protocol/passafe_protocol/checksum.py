"""Checksum at the end of every message, so that a damaged message is not mistaken for a valid one.

The last six bytes are the protobuf field ``checksum`` (number 99, fixed32): the CRC-32 of zlib, Ethernet and PNG over
all bytes before it, little-endian. A protobuf reader sees it as an ordinary field, so logs remain readable and can be
checked on their own. It detects every one-bit and two-bit error and every burst of up to 32 bits.
"""

from typing import Final
from zlib import crc32

FIELD_NUMBER: Final = 99
_FIXED32: Final = 5
_KEY_VALUE: Final = FIELD_NUMBER << 3 | _FIXED32
KEY: Final = bytes((_KEY_VALUE & 0x7F | 0x80, _KEY_VALUE >> 7))
"""Protobuf key of the field: number and wire type as a varint."""

CHECKSUM_BYTES: Final = len(KEY) + 4


def with_checksum(data: bytes) -> bytes:
    """Append the checksum to the bytes of a message."""
    return data + KEY + crc32(data).to_bytes(4, "little")


def is_intact(data: bytes) -> bool:
    """Check that bytes end with the checksum of the bytes before it."""
    # A short copy is made sooner than a view; of fewer than six bytes the key is not whole.
    return crc32(data[:-CHECKSUM_BYTES]) == int.from_bytes(data[-4:], "little") and data[-CHECKSUM_BYTES:-4] == KEY
