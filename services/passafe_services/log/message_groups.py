"""Reads columns of messages in groups: each group laid out alike, or decoded one by one."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic

from passafe_services.log.column import Column, Counts, Numbers, Places, Ragged, Texts
from passafe_services.log.message_field import LENGTH, MessageField, fields_of
from passafe_services.log.wire_layout import Bytes, Slot, WireLayout, read_numbers


@dataclass(slots=True, eq=False)
class MessageLayout:
    """Layout with one message of it."""

    topic: Topic
    wire: WireLayout
    message: tuple[Header, Message]
    _plans: dict[str, "ReadingPlan"] = field(default_factory=dict)

    def plan(self, wanted: MessageField) -> "ReadingPlan":
        """Return how to read a field, planned once."""
        if wanted.path not in self._plans:
            self._plans[wanted.path] = ReadingPlan.of(wanted, self)
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


class ReadingPlan(NamedTuple):
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
    def of(cls, wanted: MessageField, layout: MessageLayout) -> "ReadingPlan":
        """Plan the reading of a field."""
        values = wanted.values(*layout.message)
        if wanted.is_text:
            words = tuple(dict.fromkeys(values))
            return cls(np.array([words.index(value) for value in values], dtype=np.int32), words, (), whole=False)
        slots = () if wanted.is_length else tuple(slot for slot in layout.wire.slots if slot.path == wanted.path)
        start_of = _starts(wanted, layout, slots)
        placed = tuple((start_of[slot.element], slot) for slot in slots)
        held = sum(slot.numbers for slot in slots)
        return cls(np.array(values, dtype=wanted.dtype), (), placed, whole=held == len(values))


def _starts(wanted: MessageField, layout: MessageLayout, slots: Sequence[Slot]) -> dict[tuple[int, ...], int]:
    """Return the place of the first value of each slot, by the element of the list that it belongs to."""
    if not slots or not slots[0].element:
        return {(): 0}
    length = fields_of(layout.topic).get(f"{wanted.path}.{LENGTH}")
    if length is None:
        return {slot.element: slot.element[0] for slot in slots}
    lengths = length.values(*layout.message)
    starts = np.cumsum([0, *lengths])
    return {slot.element: int(starts[slot.element[0]]) for slot in slots}


class MessageGroup(NamedTuple):
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


def column_of(wanted: MessageField, groups: Sequence[MessageGroup], rows: Sequence[Places], size: int) -> Column:
    """Return the column of a field, the rows of all groups in order."""
    if len(groups) == 1 and not wanted.is_text and (rows[0] == np.arange(size)).all():
        values, counts, _ = groups[0].read(wanted)
        return Ragged(values, counts) if wanted.is_ragged else values
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
