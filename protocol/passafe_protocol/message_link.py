"""Link that carries messages: it corrupts their encoded bytes and reports its effects and state as messages."""

from typing import Final, TypeAlias

from passafe_protocol.codec import decode, encode
from passafe_protocol.errors import LinkSettingsError, ProtocolError
from passafe_protocol.link import Link
from passafe_protocol.link_effect import Effects
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.messages import Header, LinkConfig, LinkEvent, LinkSource, LinkState, Message, Received
from passafe_protocol.sequence_window import Arrival
from passafe_protocol.session_guards import SessionGuards
from passafe_protocol.topics import LINKS

Carried: TypeAlias = tuple[Header, Message | bytes, int]
"""Header, body, or the corrupted bytes of both, and the term of the sender's session (see ``Received``)."""

_ACCEPTED: Final = frozenset({Arrival.FRESH, Arrival.REORDERED})


class MessageLink(Link[Carried]):
    """Link between the publishers of one topic and one reader.

    Only messages to be corrupted are encoded: one bit is flipped, and the reader's decoder decides what is received.
    A copy that arrives after its message is refused, as the reader refuses duplicates from the bus.

    Attributes:
        topic: The topic.
        refused_corrupted: Delivered messages that the decoder refused.
        refused_duplicate: Delivered messages that were duplicates.
    """

    def __init__(self, name: str, settings: LinkSettings) -> None:
        """Create a link with nothing in flight.

        Args:
            name: Its name, one of ``LINKS``.
            settings: Its settings.
        """
        super().__init__(name, settings, _flip_bit)
        self.topic = LINKS[name].topic
        self.refused_corrupted = self.refused_duplicate = 0
        self._guards: dict[str, SessionGuards] = {}  # by source; which session is current was decided at the entrance
        self._checks_received = self._may_damage()
        self._last_config = ("", 0, 0)
        self._refusal = ""

    def reconfigure(self, settings: LinkSettings) -> None:
        """Replace the settings, see ``Link.reconfigure``."""
        super().reconfigure(settings)
        self._checks_received = self._checks_received or self._may_damage()

    def configure(self, header: Header, config: LinkConfig) -> None:
        """Apply a requested configuration; the next ``state`` reports the outcome.

        Args:
            header: Header of the request.
            config: The request.
        """
        self._last_config = (header.source, header.epoch, header.sequence)
        self._refusal = ""
        try:
            self.reconfigure(settings_of(config.parameters, self.settings.trace_s, self.settings.delay_trace_s))
        except LinkSettingsError as error:
            self._refusal = str(error)

    def pop_received(self, now_ns: int) -> list[Received]:
        """Remove and return the messages that arrived by ``now_ns`` and are accepted, in order of arrival."""
        if not self._checks_received:
            return [
                Received(header, body, at_ns, term)  # type: ignore[arg-type]  # nothing was damaged
                for at_ns, (header, body, term) in self.pop_arrived(now_ns)
            ]
        received = []
        for at_ns, carried in self.pop_arrived(now_ns):
            message = self._decoded(carried, at_ns)
            if message is not None:
                received.append(Received(*message, at_ns, carried[2]))
        return received

    def events(self, header: Header, effects: Effects) -> list[LinkEvent]:
        """Return the effects of ``put`` on the message with this header as events."""
        return [LinkEvent(self.name, done, self.topic.name, header.sequence, cause) for done, cause in effects]

    def state(self, trigger: str, sources: tuple[LinkSource, ...]) -> LinkState:
        """Return the state of the link as a message.

        Args:
            trigger: Reason for publishing: ``start``, ``period``, ``scheduled``, ``requested`` or ``end``.
            sources: Sessions of the senders whose messages entered.
        """
        return LinkState(
            self.name,
            self.topic.name,
            parameters_of(self.settings),
            len(self.settings.trace_s or self.settings.delay_trace_s),
            *self.counts,
            self.refused_corrupted,
            self.refused_duplicate,
            trigger,
            *self._last_config,
            self._refusal,
            sources,
        )

    def _may_damage(self) -> bool:
        return self.settings.duplicate > 0.0 or self.settings.corrupt > 0.0

    def _decoded(self, carried: Carried, at_ns: int) -> tuple[Header, Message] | None:
        header, body, _ = carried
        if isinstance(body, bytes):
            try:
                header, body = decode(self.topic, body)
            except ProtocolError:
                self.refused_corrupted += 1
                return None
        if self._guards.setdefault(header.source, SessionGuards()).classify(header, at_ns) not in _ACCEPTED:
            self.refused_duplicate += 1
            return None
        return header, body


def _flip_bit(carried: Carried, position: float) -> Carried:
    header, body, term = carried
    data = bytearray(body if isinstance(body, bytes) else encode(header, body))
    bit = int(position * 8 * len(data))
    data[bit // 8] ^= 1 << bit % 8
    return header, bytes(data), term
