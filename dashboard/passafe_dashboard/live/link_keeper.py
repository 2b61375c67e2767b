"""Keep requested settings of links in force when the process that reads a link starts anew, by itself or in a new run.

The settings of a link are with its reader: another session of it begins with those of its scenario.
"""

from collections.abc import Callable
from typing import Final

from passafe_protocol.messages import LinkConfig, LinkParameters
from passafe_protocol.topics import LINKS
from passafe_services.loop.link_states import NewestLinkStates

REPEAT_NS: Final = 1_000_000_000
"""Time after which a request without an effect is repeated, ns."""

Publish = Callable[[LinkConfig, int], object]
"""Publishes a request at a monotonic time, ns."""

Report = Callable[[str, int], object]
"""Reports what was done, at a monotonic time, ns."""


class LinkKeeper:
    """Settings that somebody requested of a link, and their repetition to the next session of its reader.

    Args:
        board: Newest states of the links.
        publish: Publishes a request.
        report: Reports that settings were requested again.
    """

    def __init__(self, board: NewestLinkStates, publish: Publish, report: Report) -> None:
        self._board = board
        self._publish = publish
        self._report = report
        self._wanted: dict[str, tuple[int, LinkParameters]] = {}  # by link, with the session of its reader
        self._asked_ns: dict[str, int] = {}

    def step(self, now_ns: int) -> None:
        """Note settings that were requested and accepted; request them of sessions that do not have them."""
        for link in LINKS:
            newest = self._board.newest(link)
            if newest is None:
                continue
            session, state = newest.header.epoch, newest.state
            if state.config_source and not state.refusal:
                self._wanted[link] = session, state.parameters
            elif link in self._wanted and self._wanted[link][0] != session:
                self._request_again(link, state.parameters, now_ns)

    def _request_again(self, link: str, in_force: LinkParameters, now_ns: int) -> None:
        _, wanted = self._wanted[link]
        asked_ns = self._asked_ns.get(link)
        if in_force == wanted or (asked_ns is not None and now_ns - asked_ns < REPEAT_NS):
            return
        self._asked_ns[link] = now_ns
        self._publish(LinkConfig(link, wanted), now_ns)
        reader = LINKS[link].reader
        self._report(
            f"{link}: {reader} has started anew: the settings that were requested before are set again", now_ns
        )
