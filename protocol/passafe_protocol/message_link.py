"""A link that carries messages: corruption happens to their bytes, and what the link does is told as messages."""

from typing import Final, TypeAlias

from passafe_protocol.codec import decode, encode
from passafe_protocol.errors import LinkSettingsError, ProtocolError
from passafe_protocol.link import Link
from passafe_protocol.link_effect import Effects
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.messages import Header, LinkConfig, LinkEvent, LinkSource, LinkState, Message, Received
from passafe_protocol.sequence import Arrival, SequenceGuard
from passafe_protocol.topics import LINKS

Carried: TypeAlias = tuple[Header, Message | bytes]
"""Header and body, or the bytes of both once they are damaged."""

_REPEATED: Final = frozenset({Arrival.REPEATED, Arrival.FOREIGN})


class MessageLink(Link[Carried]):
    """A link on the way of one topic to one reader.

    A corrupted message is encoded, one bit of it is flipped, and what comes out is what the reader's decoder makes of
    it. Only then is anything encoded. A copy that comes out after its message is refused, as the reader refuses what
    the bus repeats.

    Attributes:
        topic: The topic.
        refused_corrupted: Of the messages that came out, those that the decoder refused.
        refused_duplicate: Those that had come out before.
    """

    def __init__(self, name: str, settings: LinkSettings) -> None:
        """Make a link with nothing under way.

        Args:
            name: Its name, one of ``LINKS``.
            settings: Its settings.
        """
        super().__init__(name, settings, _flip_bit)
        self.topic = LINKS[name].topic
        self.refused_corrupted = self.refused_duplicate = 0
        self._guards: dict[str, SequenceGuard] = {}
        self._judges = self._may_spoil()
        self._asked = ("", 0, 0)
        self._refusal = ""

    def reconfigure(self, settings: LinkSettings) -> None:
        """Put other settings in force, see ``Link.reconfigure``."""
        super().reconfigure(settings)
        self._judges = self._judges or self._may_spoil()

    def configure(self, header: Header, config: LinkConfig) -> None:
        """Do what a message asks for; the next ``state`` tells what came of it.

        Args:
            header: Header of the message.
            config: The message.
        """
        self._asked = (header.source, header.epoch, header.sequence)
        self._refusal = ""
        try:
            self.reconfigure(settings_of(config.parameters, self.settings.trace_s))
        except LinkSettingsError as error:
            self._refusal = str(error)

    def arrived(self, now_ns: int) -> list[Received]:
        """Messages that came out by ``now_ns`` and that the reader takes, in order of arrival."""
        if not self._judges:
            return [Received(header, body, at_ns) for at_ns, (header, body) in self.take(now_ns)]  # type: ignore[arg-type]  # nothing was damaged
        received = []
        for at_ns, carried in self.take(now_ns):
            message = self._judged(carried)
            if message is not None:
                received.append(Received(*message, at_ns))
        return received

    def events(self, header: Header, effects: Effects) -> list[LinkEvent]:
        """What ``put`` did to the message with this header, as messages."""
        return [LinkEvent(self.name, done, self.topic.name, header.sequence, cause) for done, cause in effects]

    def state(self, trigger: str, sources: tuple[LinkSource, ...]) -> LinkState:
        """The link as it is.

        Args:
            trigger: Why it is told: ``start``, ``period``, ``scheduled``, ``asked`` or ``end``.
            sources: Which messages were put in.
        """
        return LinkState(
            self.name,
            self.topic.name,
            parameters_of(self.settings),
            len(self.settings.trace_s),
            *self.counts,
            self.refused_corrupted,
            self.refused_duplicate,
            trigger,
            *self._asked,
            self._refusal,
            sources,
        )

    def _may_spoil(self) -> bool:
        return self.settings.duplicate > 0.0 or self.settings.corrupt > 0.0

    def _judged(self, carried: Carried) -> tuple[Header, Message] | None:
        header, body = carried
        if isinstance(body, bytes):
            try:
                header, body = decode(self.topic, body)
            except ProtocolError:
                self.refused_corrupted += 1
                return None
        if self._guards.setdefault(header.source, SequenceGuard()).judge(header) in _REPEATED:
            self.refused_duplicate += 1
            return None
        return header, body


def _flip_bit(carried: Carried, place: float) -> Carried:
    header, body = carried
    data = bytearray(body if isinstance(body, bytes) else encode(header, body))
    bit = int(place * 8 * len(data))
    data[bit // 8] ^= 1 << bit % 8
    return header, bytes(data)
