"""Lockstep driver: runs all nodes of a closed loop in one process, in virtual time, without a network."""

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import Any, Final

from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import VIRTUAL_CLOCK, Header, LinkSource, LinkState, Message, Received, Record
from passafe_protocol.topics import LINK_EVENT, LINK_STATE, Topic

from passafe_services.loop.inlet import require_links
from passafe_services.loop.link_control import LinkControl
from passafe_services.node import Node

Observer = Callable[[Topic, Header, Message], None]

Tap = Callable[[Any], object]
"""Called with each outgoing item of a node on a topic: a message, or the function that would return it."""

START_NS: Final = 1_000_000_000
"""Virtual monotonic time of the first step; not zero, so that no time is mistaken for a missing one."""

_END_OF_TIME_NS: Final = 2**62

_arrival = attrgetter("received_ns")


class Lockstep:
    """Steps every node once per period, in a fixed order; messages arrive through the links of the topic table.

    A message without delay reaches nodes that step later in the same period at once, others one period later. Two runs
    with the same nodes, links and seeds exchange identical messages to the last byte.

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
            nodes: The nodes in the order in which they step.
            period_ns: Virtual time between two steps, ns.
            links: Settings by name of the link; a link without settings delivers every message at once.
            link_changes: Scheduled changes of these settings.
            wall_offset_ns: Wall clock minus virtual monotonic clock, ns.
            epoch: Session epoch in every header.
            observer: Called with every message when it is sent; without an observer, telemetry without subscribers is
                not computed.
            taps: By topic, called with each outgoing item whether or not its message is computed, so that a few values
                of every tick can be read without the cost of telemetry.
        """
        self.now_ns = START_NS
        self._period_ns = period_ns
        self._wall_offset_ns = wall_offset_ns
        self._observer = observer
        self._taps = taps or {}
        self._slots = [_Slot(node, epoch) for node in nodes]
        self._readers: dict[Topic, list[_Reader]] = {}
        self._ended: dict[Topic, list[LinkSource]] = {}  # messages sent by sessions that were killed
        self._due_ns = 0  # next time at which a link changes or reports its state
        require_links([*(links or {}), *(change.link for change in link_changes)])
        impaired = {change.link: LinkSettings() for change in link_changes} | dict(links or {})
        for slot in self._slots:
            for topic in slot.node.subscribes:
                link = self._link(topic, slot, impaired)
                self._readers.setdefault(topic, []).append((slot, link))
            slot.control = LinkControl([*slot.links, *slot.bypassed_links], link_changes, self._sources)

    def run(self, steps: int) -> None:
        """Advance by a number of periods."""
        for _ in range(steps):
            due = self.now_ns >= self._due_ns
            if due:
                for slot in self._slots:
                    slot.control.advance(self.now_ns)
            for slot in self._slots:
                self._step(slot)
            if due:
                self._report_links()
            self.now_ns += self._period_ns

    def kill(self, name: str) -> None:
        """Kill a node like a process: it no longer steps, and messages in flight to it are lost.

        Args:
            name: Name of the node.
        """
        self._slot_of(name).dead = True

    def restart(self, node: Node, epoch: int) -> None:
        """Replace a node by one of the same name, like a process that is restarted.

        Args:
            node: The node; it has the same subscriptions.
            epoch: Its session, another than all previous ones.
        """
        slot = self._slot_of(node.name)
        for link in slot.links:
            link.pop_received(_END_OF_TIME_NS)
        for topic, route in slot.routes.items():
            if route.sent:
                self._ended.setdefault(topic, []).append(slot.source(route))
        slot.node, slot.dead, slot.epoch, slot.term = node, False, epoch, slot.term + 1
        slot.inbox, slot.routes = [], {}

    def _slot_of(self, name: str) -> "_Slot":
        """Return the slot of a node.

        Raises:
            ValueError: There is no node of that name.
        """
        for slot in self._slots:
            if slot.name == name:
                return slot
        raise ValueError(f"node: got {name!r}, allowed {', '.join(slot.name for slot in self._slots)}")

    def finish(self) -> None:
        """Report the last state of every link to the observer; called after the last step."""
        self._count_bypassed_links()
        for slot in self._slots:
            self._report(slot, slot.control.last_states())

    @staticmethod
    def _link(topic: Topic, slot: "_Slot", impaired: Mapping[str, LinkSettings]) -> MessageLink | None:
        """Return the injected link between a topic and a reader, if its settings ever have an effect."""
        name = topic.links.get(slot.name)
        if name is None:
            return None
        if name in impaired:
            link = MessageLink(name, impaired[name])
            slot.links.append(link)
            return link
        slot.bypassed_links.append(MessageLink(name, LinkSettings()))
        return None

    def _report_links(self) -> None:
        self._count_bypassed_links()
        for slot in self._slots:
            self._report(slot, slot.control.due_states(self.now_ns))
        self._due_ns = min((slot.control.due_ns for slot in self._slots), default=0)

    def _report(self, slot: "_Slot", states: Sequence[LinkState]) -> None:
        if self._observer is not None:
            for state in states:
                self._send(slot, self._route(slot, LINK_STATE), state)

    def _count_bypassed_links(self) -> None:
        for slot in self._slots:
            for link in slot.bypassed_links:
                link.count_passed(sum(source.received for source in self._sources(link)) - link.counts.entered)

    def _sources(self, link: MessageLink) -> tuple[LinkSource, ...]:
        """Return the messages that entered a link, by sender and session: all that were sent."""
        sent = list(self._ended.get(link.topic, ()))
        for slot in self._slots:
            route = slot.routes.get(link.topic)
            if route is not None and route.sent:
                sent.append(slot.source(route))
        return tuple(sent)

    def _step(self, slot: "_Slot") -> None:
        now_ns, observer = self.now_ns, self._observer
        inbox, slot.inbox = slot.inbox, []
        if slot.dead:
            return
        if slot.links:
            for link in slot.links:
                inbox += link.pop_received(now_ns)
            if len(inbox) > 1:
                inbox.sort(key=_arrival)
        for topic, item in slot.node.step(now_ns, inbox):
            route = slot.routes.get(topic) or self._route(slot, topic)
            if route.tap is not None:
                route.tap(item)
            if route.readers or observer is not None:
                self._send(slot, route, item if isinstance(item, Record) else item())

    def _send(self, sender: "_Slot", route: "_Route", body: Message) -> None:
        now_ns = self.now_ns
        wall_ns = now_ns + self._wall_offset_ns
        header = Header(sender.name, sender.epoch, route.sent, now_ns, now_ns, now_ns, wall_ns, VIRTUAL_CLOCK)
        route.sent += 1
        if self._observer is not None:
            self._observer(route.topic, header, body)
        for slot, link in route.readers:
            if link is None:
                slot.inbox.append(Received(header, body, now_ns, sender.term))
                continue
            effects = link.put(now_ns, (header, body, sender.term))
            if effects and self._observer is not None:
                for event in link.events(header, effects):
                    self._send(slot, self._route(slot, LINK_EVENT), event)

    def _route(self, sender: "_Slot", topic: Topic) -> "_Route":
        """Return the route of a sender's topic, created at its first message."""
        if topic not in sender.routes:
            readers = [reader for reader in self._readers.get(topic, ()) if reader[0] is not sender]
            sender.routes[topic] = _Route(topic, readers, self._taps.get(topic))
        return sender.routes[topic]


class _Slot:
    """Node with its inbox, the links that it reads and the routes of its messages.

    Links without effect are bypassed and only count messages.
    """

    control: LinkControl

    def __init__(self, node: Node, epoch: int) -> None:
        self.node = node
        self.epoch = epoch
        self.term = 0  # restarts so far: a reader's inlet would count them
        self.dead = False
        self.name = node.name
        self.inbox: list[Received] = []
        self.links: list[MessageLink] = []
        self.bypassed_links: list[MessageLink] = []
        self.routes: dict[Topic, _Route] = {}

    def source(self, route: "_Route") -> LinkSource:
        """Return the messages sent on a route."""
        return LinkSource(self.name, self.epoch, 0, route.sent - 1, route.sent)


_Reader = tuple[_Slot, MessageLink | None]
"""Reader of a topic and the link to it, unless that is bypassed."""


class _Route:
    """One topic of one sender: its readers, its tap and the number of messages sent."""

    def __init__(self, topic: Topic, readers: list[_Reader], tap: Tap | None) -> None:
        self.topic = topic
        self.readers = readers
        self.tap = tap
        self.sent = 0
