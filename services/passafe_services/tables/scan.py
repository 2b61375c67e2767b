"""First pass over a log: the columns of every table, the number of rows, the begin."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Self

from passafe_protocol.topics import TOPIC_OF_NAME, TOPICS

from passafe_services.scenarios.schema import Scenario
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow, LogMessages
from passafe_services.tables.units import units_of

BLOCK_ROWS: Final = 8192
"""Rows that are held before they are passed on."""


class Block(NamedTuple):
    """Successive rows of one table.

    Attributes:
        table: Name of the topic.
        rows: The rows, each with a value for every column of the layout.
    """

    table: str
    rows: list[list[Any]]


@dataclass(frozen=True, kw_only=True)
class LogScan:
    """Contents of a log, and a second pass over it in blocks of rows.

    Attributes:
        messages: Its messages.
        start_ns: Earliest log time, Unix time, ns, at which ``time_s`` is zero.
        layouts: Complete layout of every table, by name of the topic, in the order of the topic table.
        counts: Rows of each table, 0 for a topic without a message.
        scenario: Scenario of the run; ``None`` if the log has none that this build can read.
    """

    messages: LogMessages
    start_ns: int
    layouts: Mapping[str, TableLayout]
    counts: Mapping[str, int]
    scenario: Scenario | None

    @classmethod
    def of(cls, path: Path, topics: Iterable[str] = TOPIC_OF_NAME) -> Self:
        """Read a log once.

        Args:
            path: The log.
            topics: Names of the topics that are wanted; all of them if not given.

        Raises:
            LogReadError: The file is missing, empty, no MCAP file or no log of passafe.
        """
        messages = LogMessages(path, topics)
        layouts = {topic.name: TableLayout(topic) for topic in TOPICS}
        counts = dict.fromkeys(layouts, 0)
        for row in messages:
            layouts[row.topic.name].note(row.body)
            counts[row.topic.name] += 1
        units = units_of(messages.scenario)
        for layout in layouts.values():
            layout.name_units(units)
        return cls(
            messages=messages,
            start_ns=messages.start_ns or 0,
            layouts=layouts,
            counts=counts,
            scenario=messages.scenario,
        )

    def rows(self) -> Iterator[LoggedRow]:
        """Yield the messages again, decoded, in the order of the file.

        What was added to a log since the first pass, because it is still recorded, is left out.
        """
        left = dict(self.counts)
        for one in self.messages:
            if left[one.topic.name]:
                left[one.topic.name] -= 1
                yield one

    def blocks(self) -> Iterator[Block]:
        """Yield the rows of all tables, each table's in the order of the file."""
        waiting: dict[str, list[list[Any]]] = {name: [] for name in self.layouts}
        for one in self.rows():
            name = one.topic.name
            waiting[name].append(self.layouts[name].row(one.log_ns, self.start_ns, one.header, one.body))
            if len(waiting[name]) >= BLOCK_ROWS:
                yield Block(name, waiting[name])
                waiting[name] = []
        yield from (Block(name, rows) for name, rows in waiting.items() if rows)
