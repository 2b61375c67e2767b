"""Pack arrays of numbers for a page: single precision, differences, bytes of one weight together, deflate, base64."""

import zlib
from base64 import b64encode
from enum import IntEnum
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray

BitArray: TypeAlias = NDArray[np.uint32]

DROPPED_BITS: Final = 8
"""Bits of the mantissa of a single that are left out: what remains is exact to 3e-5 of the value."""

NS_PER_US: Final = 1000

_MASK: Final = np.uint32((1 << DROPPED_BITS) - 1)
_LARGEST: Final = 3e38
_LONGEST_US: Final = 2**32 - 1


class Rounding(IntEnum):
    """Direction in which a value may differ from the packed one."""

    DOWN = -1
    TO_ZERO = 0
    UP = 1


class PackedArrays:
    """Arrays in one text, each found by its offset; ``unpack.js`` is the reader."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._numbers = 0

    def floats(self, values: FloatArray, rounding: Rounding = Rounding.TO_ZERO) -> int:
        """Add values, shape (N,), and return their offset; an envelope is rounded outwards and holds every sample."""
        return self._add(rounded_bits(values, rounding))

    def times(self, t_ns: IntArray) -> int:
        """Add the steps between increasing times, ns, shape (N,), in µs, the first of them 0; return their offset."""
        steps = np.diff((t_ns - t_ns[:1] + NS_PER_US // 2) // NS_PER_US, prepend=0)
        return self._add(np.clip(steps, 0, _LONGEST_US).astype(np.uint32))

    def text(self) -> str:
        """Return all arrays as text."""
        return b64encode(zlib.compress(b"".join(self._parts), 9)).decode("ascii")

    def _add(self, bits: BitArray) -> int:
        """Add unsigned numbers as differences, and return their offset among all."""
        offset, self._numbers = self._numbers, self._numbers + bits.size
        steps = np.diff(bits, prepend=np.uint32(0)).view(np.int32)
        folded = ((steps << 1) ^ (steps >> 31)).astype("<i4")  # small steps of either sign have small numbers
        self._parts.append(folded.view(np.uint8).reshape(-1, 4).T.tobytes())
        return offset


def rounded_bits(values: FloatArray, rounding: Rounding) -> BitArray:
    """Return values as singles of which ``DROPPED_BITS`` bits are 0; a value keeps its sign and NaN remains."""
    nothing = np.isnan(values)
    wanted = np.clip(np.where(nothing, 0.0, values), -_LARGEST, _LARGEST)
    narrow = wanted.astype(np.float32)
    if rounding is not Rounding.TO_ZERO:
        outside = np.float32(np.inf * int(rounding))
        inward = (narrow - wanted) * int(rounding) < 0
        narrow = np.where(inward, np.nextafter(narrow, outside), narrow)
    bits = narrow.view(np.uint32)
    dropped = bits & _MASK
    negative = (bits >> np.uint32(31)).astype(bool)
    grows = {Rounding.DOWN: negative, Rounding.UP: ~negative}.get(rounding, np.zeros(bits.shape, dtype=bool))
    kept = (bits & ~_MASK) + np.where(grows & (dropped != 0), _MASK + np.uint32(1), np.uint32(0)).astype(np.uint32)
    return np.where(nothing, np.uint32(0x7FC00000), kept).astype(np.uint32)
