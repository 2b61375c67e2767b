"""What was heard of links: their newest states, and the answer to a request."""

from typing import NamedTuple

from passafe_protocol.messages import Header, LinkState
from passafe_protocol.topics import LINKS


class HeardState(NamedTuple):
    """A state and when it came.

    Attributes:
        header: Header of the message.
        state: The state.
        received_ns: Monotonic time at which it came, ns.
    """

    header: Header
    state: LinkState
    received_ns: int


class LinkBoard:
    """Newest state of every link, by the session of the process that reads it."""

    def __init__(self) -> None:
        self._newest: dict[tuple[str, str, int], HeardState] = {}

    def take(self, header: Header, state: LinkState, received_ns: int) -> None:
        """Note a state; one that a newer one overtook, or of a process that does not read the link, changes nothing."""
        if header.source != LINKS[state.link].reader:
            return
        key = (state.link, header.source, header.epoch)
        known = self._newest.get(key)
        if known is None or header.sequence > known.header.sequence:
            self._newest[key] = HeardState(header, state, received_ns)

    def newest(self, link: str) -> HeardState | None:
        """State of a link in the newest session that was heard of; ``None`` if none was."""
        heard = [each for (name, _, _), each in self._newest.items() if name == link]
        return max(heard, key=lambda each: each.header.epoch, default=None)

    def answer(self, link: str, source: str, epoch: int, sequence: int) -> HeardState | None:
        """State that tells what came of a request, or of a later one of the same session; ``None`` if none has come.

        Args:
            link: The link that it was about.
            source: Process that asked.
            epoch: Its session.
            sequence: Number of the LinkConfig.
        """
        asked = (source, epoch)
        for (name, _, _), heard in self._newest.items():
            state = heard.state
            is_answer = (state.config_source, state.config_epoch) == asked and state.config_sequence >= sequence
            if name == link and is_answer:
                return heard
        return None
