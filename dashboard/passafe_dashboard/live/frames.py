"""Make the frames of the live page's WebSocket: rows that a client has not received, and the state now.

A frame is the JSON text ``{"layout": …, "restart": bool, "lost": n, "tables": {"ticks": [row, …], "states":
[row, …]}, "now": {…}}``; a row lists the columns of ``drawn_columns`` in order, null where there is no value.
"""

from typing import Final, TypeAlias

from passafe_dashboard.decimation import SeriesRow
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.feed import Feed

Made: TypeAlias = dict[tuple[bool, int, int, int], str]
"""Frames made since the bus was read last, by restart, run and the cursors of both tables."""

KEPT: Final = 4
"""Frames kept of those: pages that keep up share one, and a whole history is large."""


class ClientFrames:
    """Frames of one client, each with the rows since the one before.

    Attributes:
        has_sent_end: Whether a frame reported the end of the run.

    Args:
        feed: The feed.
    """

    def __init__(self, feed: Feed) -> None:
        self.has_sent_end = False
        self._feed = feed
        self._run = -1
        self._ticks = 0
        self._states = 0

    def next_frame(self, now_text: str, made: Made | None = None) -> str:
        """Return the next frame.

        Args:
            now_text: JSON text of the page's state now, which all clients share.
            made: Frames made with this state: clients that have received the same rows share one.
        """
        feed, run = self._feed, self._feed.run
        self.has_sent_end = feed.end is not None
        restart = self._run != run.number
        if restart:
            self._run, self._ticks, self._states = run.number, run.ticks.first, run.states.first
        key = (restart, self._run, self._ticks, self._states)
        ticks, states = run.ticks.since(self._ticks), run.states.since(self._states)
        self._ticks, self._states = ticks.cursor, states.cursor
        if made is not None and key in made:
            return made[key]
        tables = {
            "ticks": [drawn_row(row) for row in ticks.rows],
            "states": [drawn_row(row) for row in states.rows],
        }
        head = {
            "layout": feed.scenario_id,
            "restart": restart,
            "lost": max(ticks.lost, states.lost),
            "tables": tables,
        }
        frame = f'{json_text(head)[:-1]},"now":{now_text}}}'
        if made is not None and len(made) < KEPT:
            made[key] = frame
        return frame


def drawn_row(row: SeriesRow) -> list[float | None]:
    """Return the values of the drawn columns of one row; an interruption is null in all but the time."""
    return [row.start_s, row.end_s, *row.values]
