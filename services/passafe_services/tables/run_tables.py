"""Tables of a run in memory, for a notebook or a script; ``passafe.log.read`` is the way in."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Self

import numpy as np
from passafe_protocol.topics import TOPIC_OF_NAME

from passafe.errors import NotAllowedError
from passafe_services.scenarios.schema import Scenario
from passafe_services.suggestion import suggestion
from passafe_services.tables.columns import DTYPES, Array
from passafe_services.tables.scan import LogScan
from passafe_services.tables.table import Table


class TopicNameError(NotAllowedError):
    """A topic that no log of passafe has."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunTables:
    """Messages of a run as tables, one for each topic; a topic without messages has an empty one.

    Attributes:
        path: The log.
        scenario: Effective scenario of the run; ``None`` if the log has none that this version can read.
        start_ns: Earliest log time, Unix time, ns; ``time_s`` of every table counts from there.
        tear: Description of the damage at which reading stopped; empty if the end of the log was reached.
        shortcomings: Reasons for which the log does not show that nothing is missing, in words: a file of it is not
            there, say.
        refused: Messages that do not decode, by name of the topic; they are in no table.
        tables: Every table by name of its topic.
    """

    path: Path
    scenario: Scenario | None = field(repr=False)
    start_ns: int
    tear: str
    shortcomings: tuple[str, ...]
    refused: Mapping[str, int]
    tables: Mapping[str, Table] = field(repr=False)

    @classmethod
    def read(cls, path: str | PathLike[str], *, topics: Iterable[str] | None = None) -> Self:
        """Read a log; of a torn one, what can be read.

        Args:
            path: The log.
            topics: Names of the topics to read, such as ``state``; all if not given. What is left out costs nothing.

        Raises:
            LogReadError: The file is missing, empty, no MCAP file or no log of passafe.
            TopicNameError: There is no such topic.
        """
        if isinstance(topics, str):  # it would be taken letter by letter
            raise TopicNameError("topics", repr(topics), f"names in a tuple, such as ({topics!r},)")
        wanted = tuple(TOPIC_OF_NAME if topics is None else topics)
        for name in wanted:
            if name not in TOPIC_OF_NAME:
                allowed = f"one of {', '.join(TOPIC_OF_NAME)}{suggestion(name, TOPIC_OF_NAME)}"
                raise TopicNameError("topics", repr(name), allowed)
        scan = LogScan.of(Path(path), wanted)
        return cls(
            path=Path(path),
            scenario=scan.scenario,
            start_ns=scan.start_ns,
            tables=_tables(scan),
            tear=scan.messages.tear,
            shortcomings=scan.messages.shortcomings,
            refused=dict(scan.messages.refused),
        )

    @property
    def ticks(self) -> Table:
        """Filter ticks: what was decided, and why."""
        return self.tables["tick"]

    @property
    def states(self) -> Table:
        """Plant states: where the robot was, and which input was in force."""
        return self.tables["state"]

    @property
    def commands(self) -> Table:
        """Commands of the operator."""
        return self.tables["command"]

    @property
    def inputs(self) -> Table:
        """Inputs that the filter sent to the plant."""
        return self.tables["input"]

    @property
    def link_events(self) -> Table:
        """Messages that links dropped, duplicated or corrupted."""
        return self.tables["link_event"]

    @property
    def link_states(self) -> Table:
        """Settings and counts of links, once a second."""
        return self.tables["link_state"]

    @property
    def health(self) -> Table:
        """Loop timing and message counts of every process, once a second."""
        return self.tables["health"]

    @property
    def events(self) -> Table:
        """Events in words."""
        return self.tables["event"]


def _tables(scan: LogScan) -> dict[str, Table]:
    columns: dict[str, dict[str, Array]] = {
        name: {column.name: np.empty(scan.counts[name], DTYPES[column.kind]) for column in layout.columns}
        for name, layout in scan.layouts.items()
    }
    filled = dict.fromkeys(columns, 0)
    for name, rows in scan.blocks():
        begin = filled[name]
        filled[name] = end = begin + len(rows)
        for array, values in zip(columns[name].values(), zip(*rows, strict=True), strict=True):
            array[begin:end] = values
    return {
        name: Table(
            name=name,
            rows=filled[name],
            columns=_in_order(columns[name]),
            units={column.name: column.unit for column in layout.columns if column.unit},
        )
        for name, layout in scan.layouts.items()
    }


def _in_order(columns: dict[str, Array]) -> dict[str, Array]:
    """Return the columns with the rows in order of log time; a log has what was recovered after what came in time."""
    times = np.asarray(columns["log_ns"], dtype=np.uint64)
    if np.all(times[1:] >= times[:-1]):
        return columns
    order = np.argsort(times, kind="stable")
    return {name: array[order] for name, array in columns.items()}
