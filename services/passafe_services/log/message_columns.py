"""Decodes many messages of one topic at once, into columns: as strict as the codec, at a tenth of its cost.

Messages with one layout (``wire_layout``) are read column by column. The codec decodes one of each layout, and with it
judges everything that their layout fixes: structure, texts, enumerations, lengths. What differs between them is judged
here: checksums, that numbers are finite, and the bounds of ``validation.RULES``. On a message that does not pass, or
that has no layout, the codec has the last word.
"""

from collections.abc import Collection, Sequence
from itertools import chain
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from passafe_protocol import codec
from passafe_protocol.checksum import is_intact
from passafe_protocol.codec import MAX_MESSAGE_BYTES
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Header, Message
from passafe_protocol.shapes import Shape, shape_of
from passafe_protocol.topics import Topic
from passafe_protocol.validation import RULES

from passafe_services.log.column import Column, Places
from passafe_services.log.message_field import descriptor_of, fields_of
from passafe_services.log.message_groups import MessageGroup, MessageLayout, column_of
from passafe_services.log.wire_layout import (
    Bytes,
    UnusualLayoutError,
    WireLayout,
    grouped,
    table_of,
)

RECORD: Final = "record"
"""Path of the column of decoded messages, each as (header, body)."""

CHECKSUM: Final = "checksum"
"""Column with the checksum of each message, which tells a copy from another message of the same number."""

WIRE: Final = "wire"
"""Path of the column of wire bytes."""

MOST_LAYOUTS: Final = 256
"""Layouts that are kept for each length of a message."""

LEAST_ALIKE: Final = 3
"""Messages that have to be alike for a layout of their own to pay."""


_EXPONENT: Final = 0x7F
"""Bits of the last byte of a double that are all set in an infinity, a NaN and a huge number."""


class DecodedTable(NamedTuple):
    """Messages of one topic as columns.

    Attributes:
        valid: Which of the messages are valid and have a row, by their place.
        columns: Columns by the path of their field, each with one row for each valid message.
    """

    valid: Places
    columns: dict[str, Column]


class _Bound(NamedTuple):
    path: str
    least: float
    largest: float


class ColumnDecoder:
    """Decoder of the messages of one topic, which keeps the layouts that it has met.

    Args:
        topic: The topic.
    """

    def __init__(self, topic: Topic) -> None:
        self.topic = topic
        self._fields = fields_of(topic)
        self._bounds = tuple(_bounds(shape_of(Header), "header.")) + tuple(_bounds(shape_of(topic.body), ""))
        self._known: dict[int, list[MessageLayout]] = {}

    def decode(self, messages: Sequence[bytes], paths: Collection[str]) -> DecodedTable:
        """Decode messages.

        Args:
            messages: Wire bytes of each.
            paths: Fields that are wanted as columns, see ``message_field.fields_of``.
        """
        of_length: dict[int, list[int]] = {}
        for number, data in enumerate(messages):
            if is_intact(data) and len(data) <= MAX_MESSAGE_BYTES:
                of_length.setdefault(len(data), []).append(number)
        groups: list[MessageGroup] = []
        for length, numbers in of_length.items():
            groups += self._groups(length, [messages[number] for number in numbers], np.array(numbers))
        valid = np.sort(np.concatenate([group.rows for group in groups])) if groups else np.zeros(0, dtype=np.intp)
        row_of = np.zeros(len(messages), dtype=np.intp)
        row_of[valid] = np.arange(valid.size)
        rows = [row_of[group.rows] for group in groups]
        columns = {path: column_of(self._fields[path], groups, rows, valid.size) for path in paths}
        return DecodedTable(valid, columns)

    def _groups(self, length: int, messages: Sequence[bytes], places: Places) -> list[MessageGroup]:
        """Return messages of one length in groups that are laid out alike; what is not valid is left out."""
        table = table_of(messages)
        known = self._known.setdefault(length, [])
        groups: list[MessageGroup] = []
        doubtful: list[int] = []
        left = np.ones(len(messages), dtype=np.bool_)
        for number, rows in grouped([layout.wire for layout in known], table):
            left[rows] = False
            doubtful += self._add_group(groups, known[number], places, table, rows)
        (unknown,) = np.nonzero(left)
        while unknown.size:
            layout = self._layout(messages[unknown[0]]) if unknown.size >= LEAST_ALIKE else None
            if layout is None:
                doubtful.append(int(unknown[0]))
                unknown = unknown[1:]
                continue
            self._keep(known, layout)
            same = layout.wire.matches(table[unknown])
            rows, unknown = unknown[same], unknown[~same]
            doubtful += self._add_group(groups, layout, places, table, rows)
        decoded = [(number, found) for number in doubtful if (found := self._decoded(messages[number]))]
        if decoded:
            groups.append(
                MessageGroup(places[[number for number, _ in decoded]], [found for _, found in decoded], None)
            )
        return groups

    def _add_group(
        self, groups: list[MessageGroup], layout: MessageLayout, places: Places, table: Bytes, rows: Places
    ) -> list[int]:
        """Add the group of the rows that have a layout; return those of them on which the codec has to decide."""
        of_layout = table if rows.size == len(table) else table[rows]
        fine = self._fine(layout, of_layout)
        if fine.all():
            groups.append(MessageGroup(places[rows], layout, of_layout))
            return []
        groups.append(MessageGroup(places[rows[fine]], layout, of_layout[fine]))
        doubtful: list[int] = rows[~fine].tolist()
        return doubtful

    @staticmethod
    def _keep(known: list[MessageLayout], layout: MessageLayout) -> None:
        if len(known) >= MOST_LAYOUTS:
            known.clear()
        known.append(layout)

    def _layout(self, data: bytes) -> MessageLayout | None:
        """Return the layout of a message; ``None`` if it has none that others can share, or is not valid."""
        decoded = self._decoded(data)
        if decoded is None:
            return None
        try:
            return MessageLayout(self.topic, WireLayout(descriptor_of(self.topic), data), decoded)
        except UnusualLayoutError:
            return None

    def _decoded(self, data: bytes) -> tuple[Header, Message] | None:
        try:
            return codec.decode(self.topic, data)
        except ProtocolError:
            return None

    def _fine(self, layout: MessageLayout, table: Bytes) -> NDArray[np.bool_]:
        """Return which messages with a layout are surely valid."""
        last = table[:, layout.wire.doubles]
        fine: NDArray[np.bool_] = ((last & _EXPONENT) != _EXPONENT).all(axis=1)
        for bound in self._bounds:
            numbers, varies = layout.read(self._fields[bound.path], table)
            if varies:
                fine &= ((numbers >= bound.least) & (numbers <= bound.largest)).all(axis=1)
        return fine


def columns_of(topic: Topic, messages: Sequence[tuple[Header, Message]], paths: Collection[str]) -> dict[str, Column]:
    """Return columns of decoded messages.

    Args:
        topic: Their topic.
        messages: Header and body of each.
        paths: Paths of the wanted columns, ``record`` included.
    """
    rows = np.arange(len(messages))
    group = MessageGroup(rows, messages, None)
    fields = fields_of(topic)
    columns: dict[str, Column] = {
        path: column_of(fields[path], [group], [rows], len(messages)) for path in paths if path in fields
    }
    if RECORD in paths:
        columns[RECORD] = objects(messages)
    return columns


def objects(values: Sequence[object]) -> Column:
    """Return a column of objects."""
    return np.fromiter(values, dtype=object, count=len(values))


def _bounds(shape: Shape, prefix: str) -> list[_Bound]:
    """Return the bounds of a record's numbers, and of those of the records in it."""
    own = [
        _Bound(prefix + rule.field, rule.least, rule.largest)
        for rule in RULES[shape.record_type]
        if rule.least is not None
    ]
    inner = [_bounds(part, f"{prefix}{name}.") for _, name, part in (*shape.parts, *shape.lists)]
    return [*own, *chain.from_iterable(inner)]
