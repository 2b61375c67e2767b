"""Logged ticks of one session of a filter, step by step, for a replay to compare."""

from itertools import accumulate
from typing import Final, NamedTuple, TypeAlias, cast

import numpy as np
from passafe_protocol.messages import FilterTick
from passafe_protocol.topics import TICK

from passafe_services.log.column import Column, Ragged, joined, take
from passafe_services.log.column_records import records_of
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_field import fields_of

TICK_COLUMNS: Final = tuple(fields_of(TICK))
"""Columns that a replay reads of ticks: all."""


MessageKey: TypeAlias = tuple[str, int, int]
"""Topic, session and number of a message."""

ConsumedMessage: TypeAlias = tuple[MessageKey, int, int]
"""Message that a step consumed, when it was received, ns, and the term of its sender: plain tuples, because the garbage
collector lets them be."""


class LoggedStep(NamedTuple):
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
        at: Row of the next tick to replay.
    """

    def __init__(self) -> None:
        self.columns: dict[str, Column] = {}
        self.at = 0
        self._expected = 0
        self._sequence: list[int] = []
        self._scheduled_ns: list[int] = []
        self._consumed: list[ConsumedMessage] = []
        self._first_consumed: list[int] = []

    def __len__(self) -> int:
        return len(self._sequence)

    def add(self, block: MessageBlock) -> None:
        """Take the next ticks of the session."""
        columns = {path: block.columns[path] for path in TICK_COLUMNS}
        if self.at < len(self):
            left = np.arange(self.at, len(self))
            columns = {path: joined([take(self.columns[path], left), column]) for path, column in columns.items()}
        self.columns, self.at = columns, 0
        ticks = MessageBlock(TICK, block.source, block.epoch, block.session, columns)
        self._sequence = ticks.sequence.tolist()
        self._scheduled_ns = ticks.numbers("header.scheduled_ns").tolist()
        topics = ticks.texts("consumed.topic")
        codes = cast("Ragged", topics.codes)  # of a list
        epochs, sequences, received_ns, terms = (
            ticks.ragged(f"consumed.{name}").values.tolist() for name in ("epoch", "sequence", "received_ns", "term")
        )
        names = map(topics.words.__getitem__, codes.values.tolist())
        keys = zip(names, epochs, sequences, strict=True)
        self._consumed = list(zip(keys, received_ns, terms, strict=True))
        self._first_consumed = [*accumulate(codes.counts.tolist(), initial=0)]

    def next_step(self, *, is_over: bool) -> LoggedStep | None:
        """Return the next step; ``None`` if there is none, or others of its ticks may come.

        Args:
            is_over: Whether no other ticks will come.
        """
        at, count, due = self.at, len(self), self._scheduled_ns
        if at == count:
            return None
        end = at + 1
        while end < count and due[end] == due[at]:
            end += 1
        if end == count and not is_over:
            return None
        after = self._sequence[end - 1] + 1
        return LoggedStep(
            rows=range(at, end),
            scheduled_ns=due[at],
            consumed=self._consumed[self._first_consumed[at] : self._first_consumed[end]],
            missing=after - self._expected - (end - at),
            is_open=end == count or self._sequence[end] != after,
        )

    def leave(self, step: LoggedStep) -> None:
        """Go on to the step after this one."""
        self.at = step.rows.stop
        self._expected = self._sequence[self.at - 1] + 1

    def message(self, row: int) -> FilterTick:
        """Return the message of a tick."""
        rows = np.array([row])
        [(_, body)] = records_of(TICK, {path: take(column, rows) for path, column in self.columns.items()})
        return cast("FilterTick", body)
