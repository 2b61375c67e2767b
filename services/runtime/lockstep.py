"""All nodes of a closed loop in one process, in virtual time: the same nodes as live, without a network."""

from collections.abc import Callable, Mapping, Sequence

from protocol.link import Link, LinkSettings
from protocol.messages import Header, LinkEvent, Message, Received
from protocol.topics import LINK_EVENT, Topic
from services.runtime.node import Node

Observer = Callable[[Topic, Header, Message], None]

START_NS = 1_000_000_000
"""Virtual monotonic time of the first step; not zero, so that no time is mistaken for a missing one."""

_FAR_NS = 2**62
"""Later than everything."""


class Lockstep:
    """Steps every node once a period, in a fixed order; messages arrive through the links of the topic table.

    A message without delay reaches a node that steps later in the same period at once, others one period later.
    Two runs with the same nodes, links and seeds give the same messages to the last byte.

    Attributes:
        now_ns: Virtual monotonic time of the next step, ns.
    """

    def __init__(
        self,
        nodes: Sequence[Node],
        *,
        period_ns: int,
        links: Mapping[str, LinkSettings] | None = None,
        wall_offset_ns: int = 0,
        epoch: int = 1,
        observer: Observer | None = None,
    ) -> None:
        """Connect the nodes.

        Args:
            nodes: In the order in which they step.
            period_ns: Virtual time between two steps, ns.
            links: Settings by name of the link; a link without settings passes everything at once.
            wall_offset_ns: Wall clock minus virtual monotonic clock, ns.
            epoch: Session epoch in every header.
            observer: Called with every message at the moment it is sent; without one, telemetry that nobody
                subscribes to is not even made.
        """
        self.now_ns = START_NS
        self._period_ns = period_ns
        self._wall_offset_ns = wall_offset_ns
        self._observer = observer
        self._seats = [_Seat(node, epoch) for node in nodes]
        self._readers: dict[Topic, list[_Reader]] = {}
        for seat in self._seats:
            for topic in seat.node.subscribes:
                link = self._link(topic, seat.node.name, links or {})
                seat.links += [] if link is None else [link]
                self._readers.setdefault(topic, []).append((seat, link))

    def run(self, steps: int) -> None:
        """Advance by a number of periods."""
        for _ in range(steps):
            for seat in self._seats:
                self._step(seat)
            self.now_ns += self._period_ns

    def kill(self, name: str) -> None:
        """End a node as a process is killed: it steps no more, and what is under way to it is lost with it.

        Args:
            name: The node's.
        """
        self._seat_of(name).dead = True

    def revive(self, node: Node, epoch: int) -> None:
        """Put a new node in the place of the one of the same name: a process that was started again.

        Args:
            node: The node; it subscribes to what the one before did.
            epoch: Its session, greater than all before.
        """
        seat = self._seat_of(node.name)
        for link in seat.links:
            link.take(_FAR_NS)
        seat.node, seat.dead, seat.epoch = node, False, epoch
        seat.inbox, seat.routes = [], {}

    def _seat_of(self, name: str) -> "_Seat":
        """Return the place of a node.

        Raises:
            ValueError: There is none of that name.
        """
        for seat in self._seats:
            if seat.name == name:
                return seat
        raise ValueError(f"node: got {name!r}, allowed {', '.join(seat.name for seat in self._seats)}")

    @staticmethod
    def _link(topic: Topic, reader: str, settings: Mapping[str, LinkSettings]) -> Link[tuple[Header, Message]] | None:
        """Return the injected link on the way of a topic to a reader, if it has settings."""
        if topic.link is None or topic.link_reader != reader or topic.link not in settings:
            return None
        return Link(topic.link, settings[topic.link])

    def _step(self, seat: "_Seat") -> None:
        now_ns, observer = self.now_ns, self._observer
        inbox, seat.inbox = seat.inbox, []
        if seat.dead:
            return
        if seat.links:
            for link in seat.links:
                inbox += [Received(header, body, at_ns) for at_ns, (header, body) in link.take(now_ns)]
            inbox.sort(key=_arrival)
        for topic, made in seat.node.step(now_ns, inbox):
            route = seat.routes.get(topic)
            if route is None:
                route = seat.routes[topic] = self._route(seat, topic)
            if route.readers or observer is not None:
                self._send(seat, route, made() if callable(made) else made)

    def _send(self, sender: "_Seat", route: "_Route", body: Message) -> None:
        now_ns = self.now_ns
        wall_ns = now_ns + self._wall_offset_ns
        header = Header(sender.name, sender.epoch, route.sent, now_ns, now_ns, now_ns, wall_ns)
        route.sent += 1
        if self._observer is not None:
            self._observer(route.topic, header, body)
        for seat, link in route.readers:
            if link is None:
                seat.inbox.append(Received(header, body, now_ns))
                continue
            effect = link.put(now_ns, (header, body))
            if effect is not None and self._observer is not None:
                event = LinkEvent(link.name, effect, route.topic.name, header.sequence)
                events = seat.routes.setdefault(LINK_EVENT, self._route(seat, LINK_EVENT))
                self._send(seat, events, event)

    def _route(self, sender: "_Seat", topic: Topic) -> "_Route":
        return _Route(topic, [reader for reader in self._readers.get(topic, ()) if reader[0] is not sender])


class _Seat:
    """A node, what has come in for it, the links on its way and where what it sends goes."""

    def __init__(self, node: Node, epoch: int) -> None:
        self.node = node
        self.epoch = epoch
        self.dead = False
        self.name = node.name
        self.inbox: list[Received] = []
        self.links: list[Link[tuple[Header, Message]]] = []
        self.routes: dict[Topic, _Route] = {}


_Reader = tuple[_Seat, Link[tuple[Header, Message]] | None]
"""Who reads a topic, and the link on the way there."""


class _Route:
    """One topic of one sender: who reads it, and how many messages have gone that way."""

    def __init__(self, topic: Topic, readers: list[_Reader]) -> None:
        self.topic = topic
        self.readers = readers
        self.sent = 0


def _arrival(received: Received) -> int:
    return received.received_ns
