"""Inlet of a node: decodes a message, checks its sequence number and passes it through the injected link.

The time is an argument; an inlet has no clock.
"""

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError, SessionError
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkEvent, LinkSource, Message, Received, TopicHealth
from passafe_protocol.sequence import SequenceGuard
from passafe_protocol.sequence_window import Arrival
from passafe_protocol.session_guards import SessionGuards, guard_of
from passafe_protocol.topics import LINKS, Topic

from passafe_services.loop.errors import LinkNameError
from passafe_services.node import Node

_ACCEPTED = frozenset({Arrival.FRESH, Arrival.REORDERED})


class Inlet:
    """Receives the messages of one topic for one process.

    Messages of processes that may not publish the topic, duplicates, and messages of another session than the current
    one of their sender are refused (``passafe_protocol.sequence``); a topic that admits any session has no such one.
    Reordered messages are delivered; the node decides whether they are stale. Sequence numbers are checked before the
    link, so ``gaps`` counts the losses of the bus, ``LinkEvent`` those of the link.

    Args:
        topic: The topic.
        link: Injected link on its route, if there is one.

    Attributes:
        topic: The topic.
        link: The link.
        undecodable: Messages that could not be decoded or were invalid.
        unauthorized: Messages of processes that may not publish the topic.
    """

    def __init__(self, topic: Topic, link: MessageLink | None = None) -> None:
        self.topic = topic
        self.link = link
        self.undecodable = 0
        self.unauthorized = 0
        self._guards = {source: guard_of(topic) for source in topic.publishers}
        self._arrived: list[Received] = []

    def receive_bytes(self, now_ns: int, data: bytes) -> Sequence[LinkEvent] | ProtocolError:
        """Decode and receive a message that the bus delivered.

        Returns:
            The error in the bytes, or the result of ``receive``.
        """
        try:
            header, body = decode(self.topic, data)
        except ProtocolError as error:
            self.undecodable += 1
            return _by_itself(error)
        return self.receive(now_ns, header, body)

    def receive(self, now_ns: int, header: Header, body: Message) -> Sequence[LinkEvent] | SessionError:
        """Receive a message and put it into the link.

        Args:
            now_ns: Reader's monotonic time, ns; non-decreasing.
            header: Its header.
            body: Its body.

        Returns:
            Effects of the link on it other than delay, for the driver to publish; or the reason for which it was
            refused, if its sender may be another one than the rightful.
        """
        guard = self._guards.get(header.source)
        if guard is None:
            self.unauthorized += 1
            return ()
        arrival = guard.classify(header, now_ns)
        if arrival not in _ACCEPTED:
            return () if arrival is Arrival.DUPLICATE else self._refusal(header, guard, arrival, now_ns)
        if self.link is None:
            self._arrived.append(Received(header, body, now_ns, guard.term))
            return ()
        effects = self.link.put(now_ns, (header, body, guard.term))
        return self.link.events(header, effects) if effects else ()

    def _refusal(
        self, header: Header, guard: SequenceGuard | SessionGuards, arrival: Arrival, now_ns: int
    ) -> SessionError:
        if arrival is Arrival.FOREIGN:
            allowed = f"{guard.epoch}, the session of {header.source} that is current"
            return SessionError(self.topic.name, "header.epoch", header.epoch, allowed)
        allowed = f"at most {guard.newest_possible(now_ns)}, after what came of {header.source} so far"
        return SessionError(self.topic.name, "header.sequence", header.sequence, allowed)

    def pop_received(self, now_ns: int) -> list[Received]:
        """Remove and return the messages that left the link by ``now_ns``, in order of arrival."""
        if self.link is None:
            arrived, self._arrived = self._arrived, []
            return arrived
        return self.link.pop_received(now_ns)

    @property
    def sources(self) -> tuple[LinkSource, ...]:
        """Accepted messages by publisher and session."""
        return tuple(
            LinkSource(source, *session) for source, guard in self._guards.items() for session in guard.sessions
        )

    @property
    def health(self) -> TopicHealth:
        """Counts since the start, over all publishers."""
        guards = self._guards.values()
        refused = self.undecodable + self.unauthorized
        if self.link is not None:
            refused += self.link.refused_corrupted + self.link.refused_duplicate
        return TopicHealth(
            topic=self.topic.name,
            received=sum(guard.received for guard in guards),
            gaps=sum(guard.gaps for guard in guards),
            refused=sum(guard.refused for guard in guards) + refused,
        )


def _by_itself(error: ProtocolError) -> ProtocolError:
    """Return an error without traceback and cause.

    These hold the frames that in turn hold the error. Such cycles wait for the garbage collector, which would stop a
    loop for 20 ms once a second under a flood of garbage.
    """
    error.__cause__ = error.__context__ = None
    return error.with_traceback(None)


def inlets_of(node: Node, links: Mapping[str, LinkSettings]) -> tuple[Inlet, ...]:
    """Return one inlet for each topic that the node subscribes to, with the links that the node reads.

    Args:
        node: The node.
        links: Settings by name of the link; those of other nodes are ignored, a link without settings delivers every
            message at once.

    Raises:
        LinkNameError: There is no link of a name in ``links``.
    """
    require_links(links)
    return tuple(Inlet(topic, _link_at(node, topic, links)) for topic in node.subscribes)


def require_links(names: Iterable[str]) -> None:
    """Check that links of these names exist.

    Raises:
        LinkNameError: One does not exist.
    """
    for name in names:
        if name not in LINKS:
            raise LinkNameError(name, tuple(LINKS))


def pop_inbox(inlets: Iterable[Inlet], now_ns: int) -> list[Received]:
    """Remove and return the messages that left all inlets by ``now_ns``, in order of arrival: a node's inbox.

    Messages of the same time keep the order of ``inlets``, then their own.
    """
    inbox = [message for inlet in inlets for message in inlet.pop_received(now_ns)]
    inbox.sort(key=attrgetter("received_ns"))
    return inbox


def _link_at(node: Node, topic: Topic, links: Mapping[str, LinkSettings]) -> MessageLink | None:
    name = topic.links.get(node.name)
    return None if name is None else MessageLink(name, links.get(name, LinkSettings()))
