"""Layout of a message's wire bytes: the places of its numbers, found once for all messages that are laid out alike.

Two messages of one topic and length have the same layout if their tags, lengths, texts, booleans and enumeration values
are the same bytes, and their variable-length integers end at the same places. Only then may their numbers be read
column by column. Whatever is laid out in an unusual way (unknown fields, a field twice) has no layout here: the codec
decides on such a message.
"""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from numpy.typing import NDArray

from passafe.errors import PassafeError

Bytes = NDArray[np.uint8]

VARINT, FIXED64, LENGTH, FIXED32 = 0, 1, 2, 5
MOST_VARINT_BYTES: Final = 9
"""Longest variable-length integer that fits 63 bits."""

_WORD_BYTES: Final = 8
_CONSTANT: Final = frozenset({FieldDescriptor.TYPE_BOOL, FieldDescriptor.TYPE_ENUM})
_VERSION: Final = "header.schema_version"
_SMALL: Final = frozenset({FieldDescriptor.TYPE_UINT32})
_WIRE_TYPE: Final = {
    FieldDescriptor.TYPE_DOUBLE: FIXED64,
    FieldDescriptor.TYPE_FIXED64: FIXED64,
    FieldDescriptor.TYPE_SFIXED64: FIXED64,
    FieldDescriptor.TYPE_UINT64: VARINT,
    FieldDescriptor.TYPE_UINT32: VARINT,
    FieldDescriptor.TYPE_BOOL: VARINT,
    FieldDescriptor.TYPE_ENUM: VARINT,
    FieldDescriptor.TYPE_FIXED32: FIXED32,
    FieldDescriptor.TYPE_STRING: LENGTH,
    FieldDescriptor.TYPE_MESSAGE: LENGTH,
}


class Slot(NamedTuple):
    """Place of one field's numbers in the bytes of a message.

    Attributes:
        path: Path of the field, as ``rows.dual``.
        element: Indices of the elements of the lists on the path, outermost first.
        offset: First byte.
        size: Number of bytes of a variable-length integer; 0 for doubles and 64-bit integers.
        numbers: How many: 1, or the length of a vector.
    """

    path: str
    element: tuple[int, ...]
    offset: int
    size: int
    numbers: int


class UnusualLayoutError(PassafeError):
    """Wire bytes without a layout that can be shared; only the codec may decide on them."""


class WireLayout:
    """Layout of one message.

    Args:
        descriptor: Protobuf type of the message.
        data: Wire bytes of one message of it, with its checksum.

    Attributes:
        slots: Places of its numbers; a field that is missing has none and is zero.
        doubles: Last byte of each double, which holds sign and most of the exponent.

    Raises:
        UnusualLayoutError: The bytes are laid out in a way that cannot be shared, or are no message.
    """

    def __init__(self, descriptor: Descriptor, data: bytes) -> None:
        self.slots: list[Slot] = []
        self._mask = np.zeros(padded(len(data)), dtype=np.uint8)
        self._mask[: len(data)] = 0xFF
        doubles: list[int] = []
        _Walk(data, self._mask, self.slots, doubles).message(descriptor, 0, len(data), "", ())
        self.doubles = np.array(doubles, dtype=np.intp)
        self._mask = self._mask.view(np.uint64)
        self._fixed = table_of([data]).view(np.uint64)[0] & self._mask

    def matches(self, messages: Bytes) -> NDArray[np.bool_]:
        """Return which messages of a table (``table_of``) have this layout, shape (N,)."""
        same: NDArray[np.bool_] = ((messages.view(np.uint64) & self._mask) == self._fixed).all(axis=1)
        return same


class _Walk:
    """Walk over the fields of one message, which writes down the places of its numbers."""

    def __init__(self, data: bytes, mask: Bytes, slots: list[Slot], doubles: list[int]) -> None:
        self._data = data
        self._mask = mask
        self._slots = slots
        self._doubles = doubles

    def message(self, descriptor: Descriptor, at: int, end: int, prefix: str, element: tuple[int, ...]) -> None:
        """Walk over the fields of a message, or of one in it, from byte ``at`` to ``end``."""
        counts: dict[int, int] = {}
        while at < end:
            tag, at = self._varint(at, end)
            field: Any = descriptor.fields_by_number.get(tag >> 3)
            seen = counts.get(tag >> 3, 0)
            counts[tag >> 3] = seen + 1
            if field is None or (seen and not (field.is_repeated and field.type == FieldDescriptor.TYPE_MESSAGE)):
                raise UnusualLayoutError("a field that is unknown or comes twice")
            path = prefix + field.name
            if field.is_repeated and field.type == FieldDescriptor.TYPE_DOUBLE:
                at = self._vector(tag & 7, at, end, path, element)
                continue
            if _WIRE_TYPE.get(field.type) != tag & 7:
                raise UnusualLayoutError(f"{path}: another wire type")
            if tag & 7 == LENGTH:
                length, at = self._varint(at, end)
                after = self._after(at, length, end)
                if field.type == FieldDescriptor.TYPE_MESSAGE:
                    inner = (*element, seen) if field.is_repeated else element
                    self.message(field.message_type, at, after, path + ".", inner)
                at = after
            else:
                at = self._number(field.type, tag & 7, at, end, path, element)

    def _number(self, kind: int, wire_type: int, at: int, end: int, path: str, element: tuple[int, ...]) -> int:
        if wire_type == FIXED32:  # the checksum alone
            after = self._after(at, 4, end)
            self._mask[at:after] = 0
            return after
        if wire_type == FIXED64:
            after = self._after(at, 8, end)
            self._mask[at:after] = 0
            self._slots.append(Slot(path, element, at, 0, 1))
            if kind == FieldDescriptor.TYPE_DOUBLE:
                self._doubles.append(after - 1)
            return after
        _, after = self._varint(at, end)
        if kind in _SMALL and after - at > 4:  # noqa: PLR2004 - more than 28 bits may not fit 32
            raise UnusualLayoutError(f"{path}: a large number")
        if kind not in _CONSTANT and path != _VERSION:
            self._mask[at:after] = 0x80
            self._slots.append(Slot(path, element, at, after - at, 1))
        return after

    def _vector(self, wire_type: int, at: int, end: int, path: str, element: tuple[int, ...]) -> int:
        if wire_type != LENGTH:
            raise UnusualLayoutError(f"{path}: a vector that is not packed")
        length, at = self._varint(at, end)
        after = self._after(at, length, end)
        if length % 8:
            raise UnusualLayoutError(f"{path}: not whole numbers")
        self._mask[at:after] = 0
        self._slots.append(Slot(path, element, at, 0, length // 8))
        self._doubles.extend(range(at + 7, after, 8))
        return after

    def _varint(self, at: int, end: int) -> tuple[int, int]:
        """Return the number at byte ``at`` and the byte after it."""
        value = 0
        for shift in range(MOST_VARINT_BYTES):
            if at + shift >= end:
                break
            byte = self._data[at + shift]
            value |= (byte & 0x7F) << 7 * shift
            if byte < 0x80:  # noqa: PLR2004 - the bit says that no more follow
                return value, at + shift + 1
        raise UnusualLayoutError("a number without an end, or a large one")

    @staticmethod
    def _after(at: int, length: int, end: int) -> int:
        if at + length > end:
            raise UnusualLayoutError("a field that goes beyond its message")
        return at + length


def padded(length: int) -> int:
    """Return the width of a row for so many bytes: whole words, which are compared in an eighth of the time."""
    return -(-length // _WORD_BYTES) * _WORD_BYTES


def table_of(messages: Sequence[bytes]) -> Bytes:
    """Return messages of one length as rows, shape (N, ``padded`` length)."""
    length = len(messages[0])
    padding = bytes(padded(length) - length)
    joined = padding.join([*messages, b""]) if padding else b"".join(messages)
    return np.frombuffer(joined, dtype=np.uint8).reshape(len(messages), padded(length))


def read_numbers(messages: Bytes, slot: Slot, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the numbers of a slot of messages with one layout, shape (N, count).

    Args:
        messages: Their table, see ``table_of``.
        slot: The slot.
        dtype: Type of its numbers.
    """
    if not slot.size:
        taken = np.ascontiguousarray(messages[:, slot.offset : slot.offset + 8 * slot.numbers])
        return taken.view(dtype.newbyteorder("<")).astype(dtype, copy=False).reshape(len(messages), slot.numbers)
    value = np.zeros(len(messages), dtype=np.uint64)
    for k in range(slot.size):
        part = (messages[:, slot.offset + k] & 0x7F).astype(np.uint64)
        value |= part << np.uint64(7 * k)
    return value.astype(dtype, copy=False)[:, None]


def grouped(layouts: Sequence[WireLayout], messages: Bytes) -> list[tuple[int, NDArray[np.intp]]]:
    """Return the numbers of layouts that occur among messages, each with the rows that have it."""
    left = np.arange(len(messages))
    found = []
    for number, layout in enumerate(layouts):
        if not left.size:
            break
        same = layout.matches(messages[left])
        if same.any():
            found.append((number, left[same]))
            left = left[~same]
    return found
