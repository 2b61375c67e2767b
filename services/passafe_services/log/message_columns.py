"""Decodes many messages of one topic at once, into columns: as strict as the codec, at a tenth of its cost.

Messages with one layout (``wire_layout``) are read column by column. The codec decodes one of each layout, and with it
judges everything that their layout fixes: structure, texts, enumerations, lengths. What differs between them is judged
here: checksums, that numbers are finite, and the bounds of ``validation.RULES``. On a message that does not pass, or
that has no layout, the codec has the last word.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, Final, NamedTuple

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

from passafe_services.log.column import Column, Counts, Numbers, Places, Ragged, Texts
from passafe_services.log.message_field import LENGTH, MessageField, descriptor_of, fields_of
from passafe_services.log.wire_layout import Bytes, Slot, UnusualLayoutError, WireLayout, grouped, read_numbers

RECORD: Final = "record"
"""Path of the column of decoded messages, each as (header, body)."""

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
        self._known: dict[int, list[_Layout]] = {}

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
        groups: list[_Group] = []
        for length, numbers in of_length.items():
            groups += self._groups(length, [messages[number] for number in numbers], np.array(numbers))
        valid = np.sort(np.concatenate([group.rows for group in groups])) if groups else np.zeros(0, dtype=np.intp)
        row_of = np.zeros(len(messages), dtype=np.intp)
        row_of[valid] = np.arange(valid.size)
        rows = [row_of[group.rows] for group in groups]
        columns = {path: _column(self._fields[path], groups, rows, valid.size) for path in paths}
        return DecodedTable(valid, columns)

    def _groups(self, length: int, messages: Sequence[bytes], places: Places) -> "list[_Group]":
        """Return messages of one length in groups that are laid out alike; what is not valid is left out."""
        table = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(len(messages), length)
        known = self._known.setdefault(length, [])
        groups, doubtful = [], []
        left = np.ones(len(messages), dtype=np.bool_)
        for number, rows in grouped([layout.wire for layout in known], table):
            left[rows] = False
            fine = self._fine(known[number], table[rows])
            groups.append(_Group(places[rows[fine]], known[number], table[rows[fine]]))
            doubtful += rows[~fine].tolist()
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
            fine = self._fine(layout, table[rows])
            groups.append(_Group(places[rows[fine]], layout, table[rows[fine]]))
            doubtful += rows[~fine].tolist()
        decoded = [(number, found) for number in doubtful if (found := self._decoded(messages[number]))]
        if decoded:
            groups.append(_Group(places[[number for number, _ in decoded]], [found for _, found in decoded], None))
        return groups

    @staticmethod
    def _keep(known: "list[_Layout]", layout: "_Layout") -> None:
        if len(known) >= MOST_LAYOUTS:
            known.clear()
        known.append(layout)

    def _layout(self, data: bytes) -> "_Layout | None":
        """Return the layout of a message; ``None`` if it has none that others can share, or is not valid."""
        decoded = self._decoded(data)
        if decoded is None:
            return None
        try:
            return _Layout(self.topic, WireLayout(descriptor_of(self.topic), data), decoded)
        except UnusualLayoutError:
            return None

    def _decoded(self, data: bytes) -> tuple[Header, Message] | None:
        try:
            return codec.decode(self.topic, data)
        except ProtocolError:
            return None

    def _fine(self, layout: "_Layout", table: Bytes) -> NDArray[np.bool_]:
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
    group = _Group(rows, messages, None)
    fields = fields_of(topic)
    columns: dict[str, Column] = {
        path: _column(fields[path], [group], [rows], len(messages)) for path in paths if path in fields
    }
    if RECORD in paths:
        columns[RECORD] = objects(messages)
    return columns


def objects(values: Sequence[object]) -> Column:
    """Return a column of objects."""
    column = np.empty(len(values), dtype=object)
    for row, value in enumerate(values):
        column[row] = value
    return column


def _bounds(shape: Shape, prefix: str) -> list[_Bound]:
    """Return the bounds of a record's numbers, and of those of the records in it."""
    own = [
        _Bound(prefix + rule.field, rule.least, rule.largest)
        for rule in RULES[shape.record_type]
        if rule.least is not None
    ]
    inner = [_bounds(part, f"{prefix}{name}.") for _, name, part in (*shape.parts, *shape.lists)]
    return [*own, *chain.from_iterable(inner)]


@dataclass(slots=True, eq=False)
class _Layout:
    """Layout with one message of it."""

    topic: Topic
    wire: WireLayout
    message: tuple[Header, Message]
    _plans: dict[str, "_Plan"] = field(default_factory=dict)

    def plan(self, wanted: MessageField) -> "_Plan":
        if wanted.path not in self._plans:
            self._plans[wanted.path] = _Plan.of(wanted, self)
        return self._plans[wanted.path]

    def read(self, wanted: MessageField, table: Bytes) -> tuple[Numbers, bool]:
        """Return the values of a field, shape (N, values of a message), and whether they vary at all."""
        plan = self.plan(wanted)
        if len(plan.slots) == 1 and plan.whole:
            return read_numbers(table, plan.slots[0][1], wanted.dtype), True
        values = np.repeat(plan.constant[None], len(table), axis=0)
        for start, slot in plan.slots:
            values[:, start : start + slot.numbers] = read_numbers(table, slot, wanted.dtype)
        return values, bool(plan.slots)


class _Plan(NamedTuple):
    """Plan of reading one field of messages with one layout.

    Attributes:
        constant: Values where there is no slot, shape (values of a message,).
        words: Texts, which ``constant`` numbers.
        slots: Slots with the place of their first value in a row.
        whole: Whether the slots hold all values.
    """

    constant: Numbers
    words: tuple[str, ...]
    slots: tuple[tuple[int, Slot], ...]
    whole: bool

    @classmethod
    def of(cls, wanted: MessageField, layout: _Layout) -> "_Plan":
        values = wanted.values(*layout.message)
        if wanted.is_text:
            words = tuple(dict.fromkeys(values))
            return cls(np.array([words.index(value) for value in values], dtype=np.int32), words, (), whole=False)
        slots = () if wanted.is_length else tuple(slot for slot in layout.wire.slots if slot.path == wanted.path)
        start_of = _starts(wanted, layout, slots)
        placed = tuple((start_of[slot.element], slot) for slot in slots)
        held = sum(slot.numbers for slot in slots)
        return cls(np.array(values, dtype=wanted.dtype), (), placed, whole=held == len(values))


def _starts(wanted: MessageField, layout: _Layout, slots: Sequence[Slot]) -> dict[tuple[int, ...], int]:
    """Return the place of the first value of each slot, by the element of the list that it belongs to."""
    if not slots or not slots[0].element:
        return {(): 0}
    length = fields_of(layout.topic).get(f"{wanted.path}.{LENGTH}")
    if length is None:
        return {slot.element: slot.element[0] for slot in slots}
    lengths = length.values(*layout.message)
    starts = np.cumsum([0, *lengths])
    return {slot.element: int(starts[slot.element[0]]) for slot in slots}


class _Group(NamedTuple):
    """Messages that are laid out alike, or were decoded one by one.

    Attributes:
        rows: Place of each message.
        source: Their layout, or each message decoded.
        table: Their bytes; ``None`` for decoded ones.
    """

    rows: Places
    source: Any
    table: Bytes | None

    def read(self, wanted: MessageField) -> tuple[Numbers, Counts, tuple[str, ...]]:
        """Return the values of all messages one behind the other, their numbers, and the words for texts."""
        if self.table is not None:
            values, _ = self.source.read(wanted, self.table)
            counts = np.full(len(self.rows), values.shape[1], dtype=np.int64)
            return values.reshape(-1), counts, self.source.plan(wanted).words
        of_each = [wanted.values(*message) for message in self.source]
        counts = np.array([len(values) for values in of_each], dtype=np.int64)
        found = list(chain.from_iterable(of_each))
        words: tuple[str, ...] = ()
        if wanted.is_text:
            words = tuple(dict.fromkeys(found))
            number_of = {word: number for number, word in enumerate(words)}
            found = [number_of[word] for word in found]
        return np.array(found, dtype=wanted.dtype), counts, words


def _column(wanted: MessageField, groups: Sequence[_Group], rows: Sequence[Places], size: int) -> Column:
    """Return the column of a field, the rows of all groups in order."""
    read = [group.read(wanted) for group in groups]
    words = tuple(dict.fromkeys(word for _, _, of_group in read for word in of_group))
    counts = np.zeros(size, dtype=np.int64)
    for (_, of_group, _), places in zip(read, rows, strict=True):
        counts[places] = of_group
    starts = np.cumsum(counts) - counts
    values = np.zeros(int(counts.sum()), dtype=wanted.dtype)
    for (found, of_group, own), places in zip(read, rows, strict=True):
        coded = np.array([words.index(word) for word in own], dtype=np.int32)[found] if wanted.is_text else found
        width = int(of_group[0]) if of_group.size else 0
        if (of_group == width).all():
            values[(starts[places][:, None] + np.arange(width)).reshape(-1)] = coded
        else:
            within = np.arange(len(found)) - np.repeat(np.cumsum(of_group) - of_group, of_group)
            values[np.repeat(starts[places], of_group) + within] = coded
    column: Any = Ragged(values, counts) if wanted.is_ragged else values
    return Texts(column, words) if wanted.is_text else column
