"""The way of a message into a node: decode, judge its number, let it through the injected link.

Both drivers use it. The live driver feeds bytes through ``read``; the lockstep driver hands header and body
to ``accept`` and pays for no decoding. Neither part knows a clock: the time is an argument.
"""

from collections.abc import Iterable, Mapping
from operator import attrgetter

from protocol.codec import decode
from protocol.errors import ProtocolError
from protocol.link import Link, LinkSettings
from protocol.messages import Header, LinkEvent, Message, Received, TopicHealth
from protocol.sequence import Arrival, SequenceGuard
from protocol.topics import LINKS, Topic
from services.runtime.errors import LinkNameError
from services.runtime.node import Node

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

    def __init__(self, topic: Topic, link: Link[tuple[Header, Message]] | None = None) -> None:
        self.topic = topic
        self.link = link
        self.undecodable = 0
        self.foreign = 0
        self._guards = {source: SequenceGuard() for source in topic.publishers}
        self._arrived: list[Received] = []

    def read(self, now_ns: int, data: bytes) -> LinkEvent | ProtocolError | None:
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

    def accept(self, now_ns: int, header: Header, body: Message) -> LinkEvent | None:
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
            return None
        if guard.judge(header) not in _ADMITTED:
            return None
        if self.link is None:
            self._arrived.append(Received(header, body, now_ns))
            return None
        effect = self.link.put(now_ns, (header, body))
        if effect is None:
            return None
        return LinkEvent(self.link.name, effect, self.topic.name, header.sequence)

    def take(self, now_ns: int) -> list[Received]:
        """What has come out by ``now_ns`` and was not taken before, in order of arrival."""
        if self.link is None:
            arrived, self._arrived = self._arrived, []
            return arrived
        return [Received(*message, arrival_ns) for arrival_ns, message in self.link.take(now_ns)]

    @property
    def health(self) -> TopicHealth:
        """Counts since the start, over all publishers."""
        guards = self._guards.values()
        return TopicHealth(
            topic=self.topic.name,
            received=sum(guard.received for guard in guards),
            gaps=sum(guard.gaps for guard in guards),
            refused=sum(guard.refused for guard in guards) + self.undecodable + self.foreign,
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
    for name in links:
        if name not in LINKS:
            raise LinkNameError(name, tuple(LINKS))
    return tuple(Inlet(topic, _link_at(node, topic, links)) for topic in node.subscribes)


def take_all(inlets: Iterable[Inlet], now_ns: int) -> list[Received]:
    """A node's inbox: what came out of all inlets by ``now_ns``, in order of arrival.

    Messages of the same time keep the order of ``inlets``, then the one in which they came.
    """
    inbox = [message for inlet in inlets for message in inlet.take(now_ns)]
    inbox.sort(key=attrgetter("received_ns"))
    return inbox


def _link_at(node: Node, topic: Topic, links: Mapping[str, LinkSettings]) -> Link[tuple[Header, Message]] | None:
    if topic.link is None or topic.link_reader != node.name:
        return None
    return Link(topic.link, links.get(topic.link, LinkSettings()))
