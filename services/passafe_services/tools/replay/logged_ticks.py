"""Logged ticks of one session of a filter, step by step, for a replay to compare."""

from collections.abc import Iterator
from itertools import accumulate
from typing import Final, TypeAlias, cast

import numpy as np
from msgspec import Struct
from passafe_protocol.messages import FilterTick
from passafe_protocol.topics import TICK

from passafe_services.log.column import Column, Numbers, Ragged, joined, take
from passafe_services.log.column_records import records_of
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_field import LENGTH, fields_of

TICK_COLUMNS: Final = tuple(fields_of(TICK))
"""Columns that a replay reads of ticks: all."""


MessageKey: TypeAlias = tuple[str, int, int]
"""Topic, session and number of a message."""

ConsumedMessage: TypeAlias = tuple[MessageKey, int, int]
"""Message that a step consumed, when it was received, ns, and the term of its sender: plain tuples, because the garbage
collector lets them be."""


class LoggedStep(Struct, frozen=True, gc=False):
    """Ticks of one step of the filter.

    Attributes:
        rows: Their rows.
        scheduled_ns: Time at which the step was due, ns.
        consumed: Messages that it consumed.
        missing: Ticks that are missing before and among them.
        is_open: Whether the tick that would follow them is missing, too, so that there may have been more.
    """

    rows: range
    scheduled_ns: int
    consumed: list[ConsumedMessage]
    missing: int
    is_open: bool


class LoggedTicks:
    """Ticks in order, of which those that were replayed are left behind when others come.

    Attributes:
        columns: All columns of the ticks.
    """

    def __init__(self) -> None:
        self.columns: dict[str, Column] = {}
        self._count = 0
        self._expected = np.uint64(0)
        self._steps: list[LoggedStep] = []
        self._next = 0

    def add(self, block: MessageBlock) -> None:
        """Take the next ticks of the session."""
        columns = {path: block.columns[path] for path in TICK_COLUMNS}
        at = self._steps[self._next].rows.start if self._next < len(self._steps) else self._count
        if at:
            self._expected = cast("Numbers", self.columns["header.sequence"])[at - 1] + np.uint64(1)
        if at < self._count:
            left = np.arange(at, self._count)
            columns = {path: joined([take(self.columns[path], left), column]) for path, column in columns.items()}
        self.columns = columns
        ticks = MessageBlock(TICK, block.source, block.epoch, block.session, columns)
        self._count, self._next = len(ticks), 0
        self._steps = _steps(ticks, self._expected)

    def steps(self, *, is_over: bool) -> Iterator[LoggedStep]:
        """Yield the steps of which no other ticks may come; one is left behind when the next is asked for.

        Args:
            is_over: Whether no other ticks will come.
        """
        end = len(self._steps) if is_over else len(self._steps) - 1
        while self._next < end:
            yield self._steps[self._next]
            self._next += 1

    def message(self, row: int) -> FilterTick:
        """Return the message of a tick."""
        rows = np.array([row])
        [(_, body)] = records_of(TICK, {path: take(column, rows) for path, column in self.columns.items()})
        return cast("FilterTick", body)


def _steps(ticks: MessageBlock, expected: np.uint64) -> list[LoggedStep]:
    """Return the steps of ticks, all at once: one by one they would take as long as reading them.

    Args:
        ticks: The ticks.
        expected: Number of the first of them, if none is missing.
    """
    sequence, due = ticks.sequence, ticks.numbers("header.scheduled_ns")
    starts = np.concatenate(([0], np.nonzero(np.diff(due))[0] + 1))
    ends = np.append(starts[1:], len(ticks))
    after = sequence[ends - 1] + np.uint64(1)
    missing = after - np.append(expected, after[:-1]) - (ends - starts).astype(np.uint64)
    is_open = np.append(sequence[ends[:-1]] != after[:-1], True)
    consumed = _consumed(ticks)
    first = [*accumulate(ticks.numbers(f"consumed.{LENGTH}").tolist(), initial=0)]
    spans = starts.tolist(), ends.tolist()
    slices = map(slice, *(map(first.__getitem__, places) for places in spans))
    each = due[starts].tolist(), map(consumed.__getitem__, slices), missing.tolist(), is_open.tolist()
    return [*map(LoggedStep, map(range, *spans), *each)]


def _consumed(ticks: MessageBlock) -> list[ConsumedMessage]:
    """Return what all ticks consumed, one tick behind the other."""
    topics = ticks.texts("consumed.topic")
    codes = cast("Ragged", topics.codes)  # of a list
    epochs, sequences, received_ns, terms = (
        ticks.ragged(f"consumed.{name}").values.tolist() for name in ("epoch", "sequence", "received_ns", "term")
    )
    names = map(topics.words.__getitem__, codes.values.tolist())
    return list(zip(zip(names, epochs, sequences, strict=True), received_ns, terms, strict=True))
