"""Make the frames of the live page's WebSocket: rows that a client has not received, and the state now.

A frame is the JSON text ``{"layout": …, "restart": bool, "lost": n, "tables": {"ticks": [row, …], "states":
[row, …]}, "now": {…}}``; a row lists the columns of ``drawn_columns`` in order, null where there is no value.
"""

from passafe_dashboard.decimation import SeriesRow
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.feed import Feed


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
        self._run: int | None = None
        self._ticks = 0
        self._states = 0

    def next_frame(self, now_text: str) -> str:
        """Return the next frame.

        Args:
            now_text: JSON text of the page's state now, which all clients share.
        """
        feed, run = self._feed, self._feed.run
        self.has_sent_end = feed.end is not None
        restart = self._run != run.number
        if restart:
            self._run, self._ticks, self._states = run.number, run.ticks.first, run.states.first
        ticks, states = run.ticks.since(self._ticks), run.states.since(self._states)
        self._ticks, self._states = ticks.cursor, states.cursor
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
        return f'{json_text(head)[:-1]},"now":{now_text}}}'


def drawn_row(row: SeriesRow) -> list[float | None]:
    """Return the values of the drawn columns of one row; an interruption is null in all but the time."""
    return [row.start_s, row.end_s, *row.values]
