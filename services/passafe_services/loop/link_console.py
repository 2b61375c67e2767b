"""Session that reads and changes the settings of the links of a running system."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TypeVar

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.messages import LinkConfig, LinkParameters, LinkState
from passafe_protocol.topics import LINK_CONFIG, LINK_STATE, LINKS

from passafe_services.loop.bus import Bus, TopicReader, open_bus
from passafe_services.loop.errors import LinkNameError, LinkRefusedError, LinkSilentError
from passafe_services.loop.link_states import NewestLinkStates
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.router_endpoint import RouterEndpoint

SOURCE: Final = "console"
ANSWER_S: Final = 3.0
"""Time to wait for the state of a link, which is published once a second."""

RETRY_S: Final = 0.5
"""Interval of retries: the first request may be sent before the router has discovered its reader."""

_POLL_S: Final = 0.005

T = TypeVar("T")


class LinkConsole:
    """Reads and changes the settings of links; created by ``open_link_console``."""

    def __init__(self, bus: Bus, *, answer_s: float) -> None:
        self._reader: TopicReader = bus.reader(LINK_STATE)
        self._outlet = Outlet(bus, SOURCE, time.time_ns())
        self._states = NewestLinkStates()
        self._answer_s = answer_s

    def states(self) -> dict[str, LinkState]:
        """Return the newest states received within the timeout, by name of the link, in the order of the table."""
        self._wait_for(lambda: all(self._states.newest(name) for name in LINKS) or None)
        received = {name: self._states.newest(name) for name in LINKS}
        return {name: each.state for name, each in received.items() if each is not None}

    def state(self, name: str) -> LinkState:
        """Return the state of one link.

        Raises:
            LinkNameError: There is no such link.
            LinkSilentError: Its state was not received within the timeout.
        """
        if name not in LINKS:
            raise LinkNameError(name, tuple(LINKS))
        received = self._wait_for(lambda: self._states.newest(name))
        if received is None:
            raise LinkSilentError(name, LINKS[name].reader, self._answer_s)
        return received.state

    def configure(self, name: str, parameters: LinkParameters) -> LinkState:
        """Change the settings of a link and return its state with the new ones in force.

        Raises:
            LinkSilentError: No answer was received within the timeout.
            LinkRefusedError: The process that reads the link refused the settings.
        """
        first = self._outlet.sent(LINK_CONFIG)
        sent_s = -RETRY_S

        def answered() -> LinkState | None:
            nonlocal sent_s
            if time.monotonic() - sent_s >= RETRY_S:
                sent_s = time.monotonic()
                now_ns = time.monotonic_ns()
                self._outlet.publish(LINK_CONFIG, LinkConfig(name, parameters), scheduled_ns=now_ns, started_ns=now_ns)
            received = self._states.answer(name, SOURCE, self._outlet.epoch, first)
            return None if received is None else received.state

        state = self._wait_for(answered)
        if state is None:
            raise LinkSilentError(name, LINKS[name].reader, self._answer_s)
        if state.refusal:
            raise LinkRefusedError(name, state.refusal)
        return state

    def _wait_for(self, condition: Callable[[], T | None]) -> T | None:
        """Receive states until the condition returns a value or the timeout expires."""
        end_s = time.monotonic() + self._answer_s
        while True:
            for data in self._reader.drain():
                self._receive(data)
            found = condition()
            if found is not None or time.monotonic() >= end_s:
                return found
            time.sleep(_POLL_S)

    def _receive(self, data: bytes) -> None:
        try:
            header, state = decode(LINK_STATE, data)
        except ProtocolError:
            return  # damaged or of another version: handled as no answer
        if isinstance(state, LinkState):
            self._states.receive(header, state, time.monotonic_ns())


@contextmanager
def open_link_console(
    endpoint: RouterEndpoint, *, robot: str = DEFAULT_ROBOT, answer_s: float = ANSWER_S
) -> Iterator[LinkConsole]:
    """Open a session with the links of a system and close it at the end of the block.

    Args:
        endpoint: Address of the router.
        robot: Robot whose links they are.
        answer_s: Timeout of each answer, s.

    Raises:
        BusError: There is no router.
    """
    with open_bus(endpoint, robot=robot) as bus:
        yield LinkConsole(bus, answer_s=answer_s)
