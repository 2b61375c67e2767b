"""Driver of a re-run: steps nodes at the times at which the processes of a log took their steps."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from heapq import merge
from operator import attrgetter
from typing import Final

from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig, LinkSource, LinkState, Message, Received, Record
from passafe_protocol.topics import LINK_EVENT, LINK_STATE, Topic

from passafe_services.loop.link_control import LinkControl
from passafe_services.loop.lockstep import Observer
from passafe_services.node import Node
from passafe_services.tools.what_if.recorded_steps import FILTER, OPERATOR, PLANT, ProcessSession, Step
from passafe_services.tools.what_if.route import Place, Route, Sent

RANKS: Final = {PLANT: 0, OPERATOR: 1, FILTER: 2}
"""Order of the steps of one time, as in lockstep."""

RESTART_RANK: Final = -1
"""A restart comes before all steps of its time."""

_arrival = attrgetter("received_ns")


@dataclass(kw_only=True)
class Process:
    """Process that is run again.

    Attributes:
        name: Its name.
        sessions: Its sessions in order.
        node_of: Returns the node of a session.
        offset_ns: Clock of the filter minus its own, ns.
        routes: Routes to it, in the order in which its node subscribes.
        inbox: What came without a link.
        control: Its links.
    """

    name: str
    sessions: Sequence[ProcessSession]
    node_of: Callable[[ProcessSession], Node]
    control: LinkControl
    offset_ns: int = 0
    routes: list[Route] = field(default_factory=list)
    inbox: list[Received] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Resent:
    """Message of the log that is sent again as it was.

    Attributes:
        topic: Its topic.
        header: Its header.
        body: Its body.
        number: Its number among those of its step, see ``Place``.
        offset_ns: Clock of the filter minus that of its sender, ns.
    """

    topic: Topic
    header: Header
    body: Message
    number: int
    offset_ns: int = 0


class SentMessages:
    """Counts messages by topic, sender and session: numbers them, and tells links what entered them."""

    def __init__(self, first: dict[tuple[str, int, str], int]) -> None:
        self._first = first
        self._next: dict[tuple[str, int, str], int] = {}

    def number(self, topic: Topic, source: str, epoch: int) -> int:
        """Return the sequence number of the next message."""
        key = (topic.name, epoch, source)
        number = self._next.get(key, self._first.get(key, 0))
        self._next[key] = number + 1
        return number

    def count(self, topic: Topic, header: Header) -> None:
        """Count a message that is sent again."""
        self._next[topic.name, header.epoch, header.source] = header.sequence + 1
        self._first.setdefault((topic.name, header.epoch, header.source), header.sequence)

    def sources(self, link: MessageLink) -> tuple[LinkSource, ...]:
        """Return what entered a link."""
        return tuple(
            LinkSource(source, epoch, first, after - 1, after - first)
            for (topic, epoch, source), after in self._next.items()
            if topic == link.topic.name
            for first in (self._first.get((topic, epoch, source), 0),)
        )


class RerunLoop:
    """Re-runs the processes of a log, from its first step to its last."""

    def __init__(
        self,
        processes: Sequence[Process],
        routes: dict[Topic, list[tuple[Process, Route]]],
        resent: Iterable[Resent],
        sent: SentMessages,
        observer: Observer,
    ) -> None:
        """Connect the processes.

        Args:
            processes: The processes.
            routes: Routes of each topic with their readers.
            resent: Messages that are sent again as they were, in order.
            sent: Numbers messages.
            observer: Called with every message when it is sent.
        """
        self._processes = processes
        self._routes = routes
        self._resent = resent
        self._sent = sent
        self._observer = observer
        self._last: Step | None = None

    def steps(self) -> Iterator[int]:
        """Run, and yield the time of every step of the plant, ns."""
        streams: list[Iterator[tuple[int, int, int, Callable[[], None]]]] = [
            self._stream(process) for process in self._processes
        ]
        streams.append(self._stream_resent())
        for at_ns, rank, _, run in merge(*streams, key=lambda event: event[:3]):
            run()
            if rank == RANKS[PLANT]:
                yield at_ns
        for process in self._processes:
            if process.sessions:
                session = process.sessions[-1]
                self._report(process, session, session.steps[-1], process.control.last_states())

    def _stream(self, process: Process) -> Iterator[tuple[int, int, int, Callable[[], None]]]:
        for term, session in enumerate(process.sessions):
            run = _SessionRun(self, process, session, term)
            if term:  # what was on its way to the session before is lost, before anything is sent to this one
                yield session.steps[0].started_ns + process.offset_ns, RESTART_RANK, 0, run.clear
            for step in session.steps:
                at_ns = step.started_ns + process.offset_ns
                yield at_ns, RANKS[process.name], 0, partial(run.step, step)

    def _stream_resent(self) -> Iterator[tuple[int, int, int, Callable[[], None]]]:
        for number, each in enumerate(self._resent):
            at_ns = each.header.started_ns + each.offset_ns
            yield at_ns, RANKS[OPERATOR], number, partial(self._resend, each)

    def _resend(self, each: Resent) -> None:
        header = each.header
        self._sent.count(each.topic, header)
        self._observer(each.topic, header, each.body)
        place = Place(header.epoch, header.scheduled_ns, each.number)
        self._route(each.topic, place, header, each.body, header.sent_ns + each.offset_ns, 0)
        if isinstance(each.body, LinkConfig):
            for process in self._processes:
                process.control.configure(header, each.body)

    def send(
        self, process: Process, session: ProcessSession, step: Step, number: int, term: int, topic: Topic, body: Message
    ) -> None:
        """Send a message of a node."""
        header = Header(
            process.name,
            session.epoch,
            self._sent.number(topic, process.name, session.epoch),
            step.scheduled_ns,
            step.started_ns,
            step.sent_ns,
            step.wall_ns,
            session.clock_id,
        )
        self._observer(topic, header, body)
        place = Place(session.epoch, step.scheduled_ns, number)
        self._route(topic, place, header, body, step.sent_ns + process.offset_ns, term)

    def _route(self, topic: Topic, place: Place, header: Header, body: Message, sent_ns: int, term: int) -> None:
        for reader, route in self._routes.get(topic, ()):
            at_ns = sent_ns - reader.offset_ns
            events = route.send(Sent(place, header, body, at_ns, term))
            if events and reader.sessions:
                session = reader.sessions[-1]
                for event in events:
                    number = self._sent.number(LINK_EVENT, reader.name, session.epoch)
                    own = Header(
                        reader.name, session.epoch, number, at_ns, at_ns, at_ns, header.wall_ns, session.clock_id
                    )
                    self._observer(LINK_EVENT, own, event)

    def _report(self, process: Process, session: ProcessSession, step: Step, states: Sequence[LinkState]) -> None:
        for state in states:
            self.send(process, session, step, 0, 0, LINK_STATE, state)


class _SessionRun:
    """Run of one session of a process: its node and the messages that it sent."""

    def __init__(self, loop: RerunLoop, process: Process, session: ProcessSession, term: int) -> None:
        self._loop = loop
        self._process = process
        self._session = session
        self._term = term
        self._node: Node | None = None

    def clear(self) -> None:
        """Lose what is on its way to the process."""
        self._process.inbox.clear()
        for route in self._process.routes:
            route.clear()

    def step(self, step: Step) -> None:
        """Step the node, and send what it returns."""
        process, session, loop = self._process, self._session, self._loop
        node = self._node
        if node is None:
            self._node = node = process.node_of(session)
        now_ns, control = step.started_ns, process.control
        if now_ns >= control.due_ns:
            control.advance(now_ns)
        inbox = process.inbox[:]
        process.inbox.clear()
        for route in process.routes:
            received, events = route.receive(now_ns)
            inbox += received
            for event in events:
                loop.send(process, session, step, 0, self._term, LINK_EVENT, event)
        inbox.sort(key=_arrival)
        numbers: Counter[Topic] = Counter()
        for topic, item in node.step(step.scheduled_ns, inbox):
            body = item if isinstance(item, Record) else item()
            loop.send(process, session, step, numbers[topic], self._term, topic, body)
            numbers[topic] += 1
        if now_ns >= control.due_ns:
            for state in control.due_states(now_ns):
                loop.send(process, session, step, 0, self._term, LINK_STATE, state)
