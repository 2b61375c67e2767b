"""Frames of the live page's WebSocket: JSON text with the rows that a client has not seen and the state now.

A frame is ``{"layout": …, "restart": bool, "lost": n, "tables": {"ticks": [row, …], "states": [row, …]},
"now": {…}}``; a row lists the columns of ``drawn_columns`` in order, null where nothing came.
"""

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any

from passafe_dashboard.columns import ColumnLayout, signed_log
from passafe_dashboard.decimation import SeriesRow
from passafe_dashboard.feed import Feed


def json_text(value: object) -> str:
    """JSON of a value; numbers that JSON cannot hold become null."""
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    except ValueError:
        return json.dumps(_finite(value), allow_nan=False, separators=(",", ":"), ensure_ascii=False)


def _finite(value: Any) -> Any:  # noqa: ANN401 - JSON values of any kind
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def drawn_row(row: SeriesRow, log_indices: Sequence[int]) -> list[float | None]:
    """Values of the drawn columns of one row; an interruption has null for everything but the time."""
    drawn = [row.start_s, row.end_s, 0, *row.values]
    for index in log_indices:
        value = row.values[index]
        drawn.append(None if value is None else signed_log(value))
    return drawn


def log_indices(layout: ColumnLayout) -> tuple[int, ...]:
    """Index of each signed-log column among the tick columns."""
    columns = tuple(layout.tick_columns)
    return tuple(columns.index(name) for name in layout.log_columns)


class ClientView:
    """What one client has seen of a feed.

    Attributes:
        has_seen_end: Whether a frame said that the run is over.

    Args:
        feed: The feed.
    """

    def __init__(self, feed: Feed) -> None:
        self.has_seen_end = False
        self._feed = feed
        self._run: int | None = None
        self._ticks = 0
        self._states = 0
        self._log_indices: tuple[int, ...] = ()

    def frame(self, now_text: str) -> str:
        """Next frame: rows that are new to this client, and ``now_text``, which all clients share."""
        feed = self._feed
        self.has_seen_end = feed.end is not None
        restart = self._run != feed.run
        if restart:
            self._run, self._ticks, self._states = feed.run, feed.ticks.first, feed.states.first
            self._log_indices = log_indices(feed.layout)
        ticks, states = feed.ticks.since(self._ticks), feed.states.since(self._states)
        self._ticks, self._states = ticks.cursor, states.cursor
        tables = {
            "ticks": [drawn_row(row, self._log_indices) for row in ticks.rows],
            "states": [drawn_row(row, ()) for row in states.rows],
        }
        head = {
            "layout": feed.scenario_id,
            "restart": restart,
            "lost": max(ticks.lost, states.lost),
            "tables": tables,
        }
        return f'{json_text(head)[:-1]},"now":{now_text}}}'
