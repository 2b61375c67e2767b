"""A session that looks at the links of a running system and changes them."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TypeVar

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import LinkConfig, LinkParameters, LinkState
from passafe_protocol.topics import LINK_CONFIG, LINK_STATE, LINKS

from passafe_services.loop.bus import Bus, Reader, open_bus
from passafe_services.loop.errors import LinkNameError, LinkRefusedError, LinkSilentError
from passafe_services.loop.link_board import LinkBoard
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.router_endpoint import RouterEndpoint

SOURCE: Final = "console"
ANSWER_S: Final = 3.0
"""How long to wait for a link to be heard of: every one tells its state once a second."""

ASK_AGAIN_S: Final = 0.5
"""A request without an answer is repeated: the first may have gone before the router knew its reader."""

_LOOK_S: Final = 0.005

T = TypeVar("T")


class LinkConsole:
    """Looks at links and changes them; made by ``open_link_console``."""

    def __init__(self, bus: Bus, *, answer_s: float) -> None:
        self._reader: Reader = bus.reader(LINK_STATE)
        self._outlet = Outlet(bus, SOURCE, time.time_ns())
        self._board = LinkBoard()
        self._answer_s = answer_s

    def states(self) -> dict[str, LinkState]:
        """Newest state of every link that is heard of within the time allowed, by name, in the table's order."""
        self._wait_for(lambda: all(self._board.newest(name) for name in LINKS) or None)
        heard = {name: self._board.newest(name) for name in LINKS}
        return {name: each.state for name, each in heard.items() if each is not None}

    def state(self, name: str) -> LinkState:
        """State of one link.

        Raises:
            LinkNameError: There is no such link.
            LinkSilentError: It is not heard of within the time allowed.
        """
        if name not in LINKS:
            raise LinkNameError(name, tuple(LINKS))
        heard = self._wait_for(lambda: self._board.newest(name))
        if heard is None:
            raise LinkSilentError(name, LINKS[name].reader, self._answer_s)
        return heard.state

    def configure(self, name: str, parameters: LinkParameters) -> LinkState:
        """Ask for other settings of a link and return its state with those in force.

        Raises:
            LinkSilentError: No answer came within the time allowed.
            LinkRefusedError: The process that reads the link refused them.
        """
        first = self._outlet.sent(LINK_CONFIG)
        asked_s = -ASK_AGAIN_S

        def answered() -> LinkState | None:
            nonlocal asked_s
            if time.monotonic() - asked_s >= ASK_AGAIN_S:
                asked_s = time.monotonic()
                now_ns = time.monotonic_ns()
                self._outlet.publish(LINK_CONFIG, LinkConfig(name, parameters), scheduled_ns=now_ns, started_ns=now_ns)
            heard = self._board.answer(name, SOURCE, self._outlet.epoch, first)
            return None if heard is None else heard.state

        state = self._wait_for(answered)
        if state is None:
            raise LinkSilentError(name, LINKS[name].reader, self._answer_s)
        if state.refusal:
            raise LinkRefusedError(name, state.refusal)
        return state

    def _wait_for(self, condition: Callable[[], T | None]) -> T | None:
        """Read states until the condition gives something or the time is over."""
        end_s = time.monotonic() + self._answer_s
        while True:
            for data in self._reader.drain():
                self._take(data)
            found = condition()
            if found is not None or time.monotonic() >= end_s:
                return found
            time.sleep(_LOOK_S)

    def _take(self, data: bytes) -> None:
        try:
            header, state = decode(LINK_STATE, data)
        except ProtocolError:
            return  # of another version, or damaged: as good as silence
        if isinstance(state, LinkState):
            self._board.take(header, state, time.monotonic_ns())


@contextmanager
def open_link_console(endpoint: RouterEndpoint, *, answer_s: float = ANSWER_S) -> Iterator[LinkConsole]:
    """Session with the system behind a router, closed whatever happens.

    Args:
        endpoint: Where the router listens.
        answer_s: How long to wait for each answer.

    Raises:
        BusError: There is no router.
    """
    with open_bus(endpoint) as bus:
        yield LinkConsole(bus, answer_s=answer_s)
