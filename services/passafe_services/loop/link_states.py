"""Newest state of every link, as received from the processes that read them."""

from typing import NamedTuple

from passafe_protocol.messages import Header, LinkState
from passafe_protocol.sequence_window import Arrival
from passafe_protocol.session_guards import guard_of
from passafe_protocol.topics import LINK_STATE, LINKS


class ReceivedState(NamedTuple):
    """State of a link with the time at which it was received.

    Attributes:
        header: Header of the message.
        state: The state.
        received_ns: Monotonic time of arrival, ns.
    """

    header: Header
    state: LinkState
    received_ns: int


class NewestLinkStates:
    """Newest state of every link, from the current session of the process that reads it.

    Of a session that is no longer received nothing is kept, so that the memory is bounded by the number of links.
    """

    def __init__(self) -> None:
        self._newest: dict[str, ReceivedState] = {}
        self._guards = {link: guard_of(LINK_STATE) for link in LINKS}

    def receive(self, header: Header, state: LinkState, received_ns: int) -> None:
        """Keep a state, unless a newer one is known or its sender does not read the link."""
        if header.source != LINKS[state.link].reader:
            return
        if self._guards[state.link].classify(header, received_ns) is Arrival.FRESH:
            self._newest[state.link] = ReceivedState(header, state, received_ns)

    def newest(self, link: str) -> ReceivedState | None:
        """Return the state of a link in the current session of its reader; ``None`` before the first one."""
        return self._newest.get(link)

    def answer(self, link: str, source: str, epoch: int, sequence: int) -> ReceivedState | None:
        """Return the state that answers a request, or a later one of the same session; ``None`` before it arrives.

        Args:
            link: Link of the request.
            source: Process that sent it.
            epoch: Session of that process.
            sequence: Sequence number of the LinkConfig.
        """
        received = self._newest.get(link)
        if received is None:
            return None
        state = received.state
        is_answer = (state.config_source, state.config_epoch) == (source, epoch) and state.config_sequence >= sequence
        return received if is_answer else None
