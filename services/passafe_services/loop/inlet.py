"""The way of a message into a node: decode, judge its number, let it through the injected link.

Both drivers use it. The live driver feeds bytes through ``read``; the lockstep driver hands header and body
to ``accept`` and pays for no decoding. Neither part knows a clock: the time is an argument.
"""

from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkEvent, LinkSource, Message, Received, TopicHealth
from passafe_protocol.sequence import Arrival, SequenceGuard
from passafe_protocol.topics import LINKS, Topic

from passafe_services.loop.errors import LinkNameError
from passafe_services.node import Node

_ADMITTED = frozenset({Arrival.FRESH, Arrival.REORDERED})


class Inlet:
    """What one process receives of one topic.

    A message of a process that may not publish the topic, a repeated one and one of an ended session are
    refused. An overtaken one passes: whether it is still of use is for the node to say, which sees the same
    from a link with jitter. Numbers are judged before the link, so ``gaps`` tells what the bus lost and
    ``LinkEvent`` what the link did.

    Args:
        topic: The topic.
        link: Injected link on its way, if there is one.

    Attributes:
        topic: The topic.
        link: The link.
        undecodable: Messages that were no valid message of the topic.
        foreign: Messages of processes that may not publish it.
    """

    def __init__(self, topic: Topic, link: MessageLink | None = None) -> None:
        self.topic = topic
        self.link = link
        self.undecodable = 0
        self.foreign = 0
        self._guards = {source: SequenceGuard() for source in topic.publishers}
        self._arrived: list[Received] = []

    def read(self, now_ns: int, data: bytes) -> Sequence[LinkEvent] | ProtocolError:
        """Take in the bytes of a message that the bus delivered.

        Returns:
            What is wrong with them, or as ``accept``.
        """
        try:
            header, body = decode(self.topic, data)
        except ProtocolError as error:
            self.undecodable += 1
            return error
        return self.accept(now_ns, header, body)

    def accept(self, now_ns: int, header: Header, body: Message) -> Sequence[LinkEvent]:
        """Take in a message.

        Args:
            now_ns: Reader's monotonic time, ns; never smaller than before.
            header: Its header.
            body: Its body.

        Returns:
            What the link did to it other than delaying it, for the driver to publish.
        """
        guard = self._guards.get(header.source)
        if guard is None:
            self.foreign += 1
            return ()
        if guard.classify(header) not in _ADMITTED:
            return ()
        if self.link is None:
            self._arrived.append(Received(header, body, now_ns))
            return ()
        effects = self.link.put(now_ns, (header, body))
        return self.link.events(header, effects) if effects else ()

    def take(self, now_ns: int) -> list[Received]:
        """What has come out by ``now_ns`` and was not taken before, in order of arrival."""
        if self.link is None:
            arrived, self._arrived = self._arrived, []
            return arrived
        return self.link.pop_received(now_ns)

    @property
    def sources(self) -> tuple[LinkSource, ...]:
        """Which messages were admitted, by publisher and session."""
        return tuple(
            LinkSource(source, *session) for source, guard in self._guards.items() for session in guard.sessions
        )

    @property
    def health(self) -> TopicHealth:
        """Counts since the start, over all publishers."""
        guards = self._guards.values()
        refused = self.undecodable + self.foreign
        if self.link is not None:
            refused += self.link.refused_corrupted + self.link.refused_duplicate
        return TopicHealth(
            topic=self.topic.name,
            received=sum(guard.received for guard in guards),
            gaps=sum(guard.gaps for guard in guards),
            refused=sum(guard.refused for guard in guards) + refused,
        )


def inlets_of(node: Node, links: Mapping[str, LinkSettings]) -> tuple[Inlet, ...]:
    """One inlet for each topic that the node subscribes to, with the links that sit at this node.

    Args:
        node: The node.
        links: Settings by name of the link; those of other nodes are passed over, a link without settings
            lets everything through at once.

    Raises:
        LinkNameError: If there is no link of a name in ``links``.
    """
    require_links(links)
    return tuple(Inlet(topic, _link_at(node, topic, links)) for topic in node.subscribes)


def require_links(names: Iterable[str]) -> None:
    """Check that there are links of these names.

    Raises:
        LinkNameError: There is one that is not.
    """
    for name in names:
        if name not in LINKS:
            raise LinkNameError(name, tuple(LINKS))


def take_all(inlets: Iterable[Inlet], now_ns: int) -> list[Received]:
    """A node's inbox: what came out of all inlets by ``now_ns``, in order of arrival.

    Messages of the same time keep the order of ``inlets``, then the one in which they came.
    """
    inbox = [message for inlet in inlets for message in inlet.take(now_ns)]
    inbox.sort(key=attrgetter("received_ns"))
    return inbox


def _link_at(node: Node, topic: Topic, links: Mapping[str, LinkSettings]) -> MessageLink | None:
    name = topic.links.get(node.name)
    return None if name is None else MessageLink(name, links.get(name, LinkSettings()))
