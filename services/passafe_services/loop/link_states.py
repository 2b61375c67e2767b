"""Newest state of every link, as received from the processes that read them."""

from typing import NamedTuple

from passafe_protocol.messages import Header, LinkState
from passafe_protocol.topics import LINKS


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
    """Newest state of every link, by session of the process that reads it."""

    def __init__(self) -> None:
        self._newest: dict[tuple[str, str, int], ReceivedState] = {}

    def receive(self, header: Header, state: LinkState, received_ns: int) -> None:
        """Keep a state, unless a newer one is known or its sender does not read the link."""
        if header.source != LINKS[state.link].reader:
            return
        key = (state.link, header.source, header.epoch)
        known = self._newest.get(key)
        if known is None or header.sequence > known.header.sequence:
            self._newest[key] = ReceivedState(header, state, received_ns)

    def newest(self, link: str) -> ReceivedState | None:
        """Return the state of a link in the newest session of its reader; ``None`` before the first one."""
        received = [each for (name, _, _), each in self._newest.items() if name == link]
        return max(received, key=lambda each: each.header.epoch, default=None)

    def answer(self, link: str, source: str, epoch: int, sequence: int) -> ReceivedState | None:
        """Return the state that answers a request, or a later one of the same session; ``None`` before it arrives.

        Args:
            link: Link of the request.
            source: Process that sent it.
            epoch: Session of that process.
            sequence: Sequence number of the LinkConfig.
        """
        requester = (source, epoch)
        for (name, _, _), received in self._newest.items():
            state = received.state
            is_answer = (state.config_source, state.config_epoch) == requester and state.config_sequence >= sequence
            if name == link and is_answer:
                return received
        return None
