"""All nodes of a closed loop in one process, in virtual time: the same nodes as live, without a network."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkSource, LinkState, Message, Received, Record
from passafe_protocol.topics import LINK_EVENT, LINK_STATE, Topic

from passafe_services.loop.inlet import require_links
from passafe_services.loop.link_control import LinkControl
from passafe_services.node import Node

Observer = Callable[[Topic, Header, Message], None]

Tap = Callable[[Any], object]
"""Takes what a node hands over for a topic: a message, or what makes one, unmade."""

START_NS: Final = 1_000_000_000
"""Virtual monotonic time of the first step; not zero, so that no time is mistaken for a missing one."""

_FAR_NS: Final = 2**62
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
        link_changes: Sequence[LinkChange] = (),
        wall_offset_ns: int = 0,
        epoch: int = 1,
        observer: Observer | None = None,
        taps: Mapping[Topic, Tap] | None = None,
    ) -> None:
        """Connect the nodes.

        Args:
            nodes: In the order in which they step.
            period_ns: Virtual time between two steps, ns.
            links: Settings by name of the link; a link without settings passes everything at once.
            link_changes: Changes of these settings, planned.
            wall_offset_ns: Wall clock minus virtual monotonic clock, ns.
            epoch: Session epoch in every header.
            observer: Called with every message at the moment it is sent; without one, telemetry that nobody
                subscribes to is not even made.
            taps: By topic, each called with what a node hands over for it, before and whether or not a message is made
                of that: who needs only a few figures of every tick does not pay for its telemetry.
        """
        self.now_ns = START_NS
        self._period_ns = period_ns
        self._wall_offset_ns = wall_offset_ns
        self._observer = observer
        self._taps = taps or {}
        self._seats = [_Seat(node, epoch) for node in nodes]
        self._readers: dict[Topic, list[_Reader]] = {}
        self._ended: dict[Topic, list[LinkSource]] = {}  # what sessions that were killed had sent
        self._due_ns = 0  # no link needs anything before
        require_links([*(links or {}), *(change.link for change in link_changes)])
        impaired = {change.link: LinkSettings() for change in link_changes} | dict(links or {})
        for seat in self._seats:
            for topic in seat.node.subscribes:
                link = self._link(topic, seat, impaired)
                self._readers.setdefault(topic, []).append((seat, link))
            seat.control = LinkControl([*seat.links, *seat.open_links], link_changes, self._sources)

    def run(self, steps: int) -> None:
        """Advance by a number of periods."""
        for _ in range(steps):
            due = self.now_ns >= self._due_ns
            if due:
                for seat in self._seats:
                    seat.control.advance(self.now_ns)
            for seat in self._seats:
                self._step(seat)
            if due:
                self._tell_links()
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
            link.pop_received(_FAR_NS)
        for topic, route in seat.routes.items():
            if route.sent:
                ended = LinkSource(seat.name, seat.epoch, 0, route.sent - 1, route.sent)
                self._ended.setdefault(topic, []).append(ended)
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

    def finish(self) -> None:
        """Tell the observer the last state of every link; after the last step."""
        self._count_open_links()
        for seat in self._seats:
            self._tell(seat, seat.control.last_states())

    @staticmethod
    def _link(topic: Topic, seat: "_Seat", impaired: Mapping[str, LinkSettings]) -> MessageLink | None:
        """Return the injected link on the way of a topic to a reader, if it ever does anything."""
        name = topic.links.get(seat.name)
        if name is None:
            return None
        if name in impaired:
            link = MessageLink(name, impaired[name])
            seat.links.append(link)
            return link
        seat.open_links.append(MessageLink(name, LinkSettings()))
        return None

    def _tell_links(self) -> None:
        self._count_open_links()
        for seat in self._seats:
            self._tell(seat, seat.control.due_states(self.now_ns))
        self._due_ns = min((seat.control.due_ns for seat in self._seats), default=0)

    def _tell(self, seat: "_Seat", states: Sequence[LinkState]) -> None:
        if self._observer is not None:
            for state in states:
                self._send(seat, self._route(seat, LINK_STATE), state)

    def _count_open_links(self) -> None:
        for seat in self._seats:
            for link in seat.open_links:
                link.count_passed(sum(source.received for source in self._sources(link)) - link.counts.entered)

    def _sources(self, link: MessageLink) -> tuple[LinkSource, ...]:
        """Which messages were put into a link: all that were sent."""
        sent = list(self._ended.get(link.topic, ()))
        for seat in self._seats:
            route = seat.routes.get(link.topic)
            if route is not None and route.sent:
                sent.append(LinkSource(seat.name, seat.epoch, 0, route.sent - 1, route.sent))
        return tuple(sent)

    def _step(self, seat: "_Seat") -> None:
        now_ns, observer = self.now_ns, self._observer
        inbox, seat.inbox = seat.inbox, []
        if seat.dead:
            return
        if seat.links:
            for link in seat.links:
                inbox += link.pop_received(now_ns)
            if len(inbox) > 1:
                inbox.sort(key=_arrival)
        for topic, made in seat.node.step(now_ns, inbox):
            route = seat.routes.get(topic) or self._route(seat, topic)
            if route.tap is not None:
                route.tap(made)
            if route.readers or observer is not None:
                self._send(seat, route, made if isinstance(made, Record) else made())

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
            effects = link.put(now_ns, (header, body))
            if effects and self._observer is not None:
                for event in link.events(header, effects):
                    self._send(seat, self._route(seat, LINK_EVENT), event)

    def _route(self, sender: "_Seat", topic: Topic) -> "_Route":
        """Return the way of a sender's topic, made when it is first gone."""
        if topic not in sender.routes:
            readers = [reader for reader in self._readers.get(topic, ()) if reader[0] is not sender]
            sender.routes[topic] = _Route(topic, readers, self._taps.get(topic))
        return sender.routes[topic]


class _Seat:
    """A node, what has come in for it, the links on its way and where what it sends goes.

    What has no effect on messages is passed around: those links are open, and only count.
    """

    control: LinkControl

    def __init__(self, node: Node, epoch: int) -> None:
        self.node = node
        self.epoch = epoch
        self.dead = False
        self.name = node.name
        self.inbox: list[Received] = []
        self.links: list[MessageLink] = []
        self.open_links: list[MessageLink] = []
        self.routes: dict[Topic, _Route] = {}


_Reader = tuple[_Seat, MessageLink | None]
"""Who reads a topic, and the link on the way there unless it is open."""


class _Route:
    """One topic of one sender: who reads it, and how many messages have gone that way."""

    def __init__(self, topic: Topic, readers: list[_Reader], tap: Tap | None) -> None:
        self.topic = topic
        self.readers = readers
        self.tap = tap
        self.sent = 0


def _arrival(received: Received) -> int:
    return received.received_ns
