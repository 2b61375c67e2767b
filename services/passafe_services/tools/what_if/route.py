"""Routes of a re-run: how a message comes from the step that sends it to the step that receives it."""

from collections.abc import Mapping, Sequence
from heapq import heappop, heappush
from typing import Final, NamedTuple, Protocol

from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkEvent, LinkSource, Message, Received

from passafe_services.loop.link_control import LinkControl

LOST_NS: Final = -1
"""LoggedArrival of a message that never came."""

END_NS: Final = 2**62
"""A time after every arrival."""


class Place(NamedTuple):
    """Place of a message among those that its sender sends, the same in the log and in its re-run.

    Attributes:
        epoch: Session of the sender.
        scheduled_ns: When the step that sends it was due, ns.
        number: Its number among the messages of that step and topic.
    """

    epoch: int
    scheduled_ns: int
    number: int


class LoggedArrival(NamedTuple):
    """LoggedArrival of a logged message at a reader.

    Attributes:
        at_ns: Time by the reader's clock, ns; ``LOST_NS`` if it never came.
        term: Changes of session of the sender that the reader had seen.
        rank: Its number among the messages of the step that received it.
    """

    at_ns: int
    term: int = 0
    rank: int = 0


class Sent(NamedTuple):
    """A message on its way.

    Attributes:
        place: Its place.
        header: Its header.
        body: Its body.
        sent_ns: When it was sent, by the reader's clock, ns.
        term: Sessions of its sender that ended before.
    """

    place: Place
    header: Header
    body: Message
    sent_ns: int
    term: int


class Route(Protocol):
    """Route of the messages of one topic to one reader.

    Attributes:
        link: The injected link on it, if there is one.
    """

    link: MessageLink | None

    def send(self, sent: Sent) -> Sequence[LinkEvent]:
        """Put a message in, and return the effects of the link on it."""
        ...

    def receive(self, now_ns: int) -> tuple[list[Received], Sequence[LinkEvent]]:
        """Return the messages that came by ``now_ns``, reader's clock, ns, and the effects of the link on those."""
        ...

    def clear(self) -> None:
        """Lose what is on its way: the reader was restarted."""
        ...


class DirectRoute:
    """Route of a run in virtual time without an injected link: the reader has a message as soon as it is sent.

    Args:
        link: Counts the messages.
        inbox: What came to the reader by any such route, in order.
    """

    def __init__(self, link: MessageLink | None, inbox: list[Received]) -> None:
        self.link = link
        self._inbox = inbox

    def send(self, sent: Sent) -> Sequence[LinkEvent]:
        """Deliver a message."""
        self._inbox.append(Received(sent.header, sent.body, sent.sent_ns, sent.term))
        if self.link is not None:
            self.link.count_passed(1)
        return ()

    def receive(self, now_ns: int) -> tuple[list[Received], Sequence[LinkEvent]]:
        """Return nothing: the inbox has it."""
        del now_ns
        return [], ()

    def clear(self) -> None:
        """Lose what was delivered."""
        self._inbox.clear()


class VirtualRoute:
    """Route of a run in virtual time through a link, which a message enters when it is sent.

    Args:
        link: The injected link.
        control: Applies the changes of its settings.
    """

    def __init__(self, link: MessageLink, control: LinkControl) -> None:
        self.link: MessageLink | None = link
        self._link = link
        self._control = control

    def send(self, sent: Sent) -> Sequence[LinkEvent]:
        """Put a message into the link."""
        if sent.sent_ns >= self._control.due_ns:
            self._control.advance(sent.sent_ns)
        effects = self._link.put(sent.sent_ns, (sent.header, sent.body, sent.term))
        return self._link.events(sent.header, effects) if effects else ()

    def receive(self, now_ns: int) -> tuple[list[Received], Sequence[LinkEvent]]:
        """Return the messages that left the link."""
        return self._link.pop_received(now_ns), ()

    def clear(self) -> None:
        """Empty the link."""
        self._link.pop_received(END_NS)


class BusRoute:
    """Route of a live run: the bus delivers a message to the reader, whose next step puts it into the link.

    Args:
        link: The injected link, if there is one.
        arrivals: When the bus delivered the messages of the log, by place, reader's clock.
        latency_ns: Time that it takes for others, ns.
    """

    def __init__(self, link: MessageLink | None, arrivals: Mapping[Place, LoggedArrival], latency_ns: int) -> None:
        self.link = link
        self._arrivals = arrivals
        self._latency_ns = latency_ns
        self._on_bus: list[tuple[int, int, int, Sent]] = []
        self._number = 0
        self._entered: dict[tuple[str, int], tuple[int, int, int]] = {}  # first and newest number, and how many

    @property
    def sources(self) -> tuple[LinkSource, ...]:
        """Messages that entered the link, by sender and session."""
        return tuple(LinkSource(*sender, *numbers) for sender, numbers in self._entered.items())

    def send(self, sent: Sent) -> Sequence[LinkEvent]:
        """Hand a message to the bus."""
        known = self._arrivals.get(sent.place)
        at_ns, _, rank = LoggedArrival(sent.sent_ns + self._latency_ns) if known is None else known
        if at_ns != LOST_NS:
            self._number += 1
            heappush(self._on_bus, (at_ns, rank, self._number, sent))
        return ()

    def receive(self, now_ns: int) -> tuple[list[Received], Sequence[LinkEvent]]:
        """Put what the bus delivered into the link, and return what left it."""
        events: list[LinkEvent] = []
        came: list[Received] = []
        while self._on_bus and self._on_bus[0][0] <= now_ns:
            sent = heappop(self._on_bus)[3]
            if self.link is None:
                came.append(Received(sent.header, sent.body, now_ns, sent.term))
            else:
                self._count(sent.header)
                effects = self.link.put(now_ns, (sent.header, sent.body, sent.term))
                events += self.link.events(sent.header, effects)
        return came if self.link is None else self.link.pop_received(now_ns), events

    def _count(self, header: Header) -> None:
        number = header.sequence
        first, newest, count = self._entered.get((header.source, header.epoch), (number, number, 0))
        self._entered[header.source, header.epoch] = (min(first, number), max(newest, number), count + 1)

    def clear(self) -> None:
        """Empty bus and link."""
        self._on_bus.clear()
        if self.link is not None:
            self.link.pop_received(END_NS)


class RecordedRoute:
    """Route on which the log says what became of each message, link and network together.

    A message that the log does not have takes as long as the one before it.

    Args:
        arrivals: When the messages of the log came, by place, reader's clock.
        latency_ns: Time that a message takes before the first arrival is known, ns.
    """

    link: MessageLink | None = None

    def __init__(self, arrivals: Mapping[Place, LoggedArrival], latency_ns: int) -> None:
        self._arrivals = arrivals
        self._delay_ns = latency_ns
        self._pending: list[tuple[int, int, int, Received]] = []
        self._number = 0

    def send(self, sent: Sent) -> Sequence[LinkEvent]:
        """Look up when a message comes."""
        known = self._arrivals.get(sent.place)
        at_ns, term, rank = (sent.sent_ns + self._delay_ns, sent.term, 0) if known is None else known
        if at_ns != LOST_NS:
            self._delay_ns = max(at_ns - sent.sent_ns, 0)
            self._number += 1
            heappush(self._pending, (at_ns, rank, self._number, Received(sent.header, sent.body, at_ns, term)))
        return ()

    def receive(self, now_ns: int) -> tuple[list[Received], Sequence[LinkEvent]]:
        """Return the messages that came."""
        received = []
        while self._pending and self._pending[0][0] <= now_ns:
            received.append(heappop(self._pending)[3])
        return received, ()

    def clear(self) -> None:
        """Keep all: the log says what became of it."""
