"""Turn the stream of messages into the state of the page: pure, with no clock, network or thread of its own.

``push`` takes a few microseconds, so a thousand ticks and states a second cost about a percent of a core.
"""

from collections import deque
from collections.abc import Callable, Sequence
from hashlib import sha256
from typing import Any, Final, NamedTuple

from passafe_protocol.messages import (
    Event,
    FilterTick,
    Header,
    Health,
    LinkEvent,
    LinkState,
    Message,
    OperatorLease,
    PlantState,
    ScenarioInfo,
    TopicHealth,
)
from passafe_protocol.topics import (
    EVENT,
    HEALTH,
    LEASE,
    LINK_EVENT,
    LINK_STATE,
    SCENARIO,
    STATE,
    TICK,
    TOPIC_OF_BODY,
    Topic,
)
from passafe_services.loop.link_states import NewestLinkStates
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.extremum import Extremum
from pydantic import ValidationError

from passafe.errors import PassafeError
from passafe_dashboard.barrier_values import BarrierValues
from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.decimation import NS_PER_S
from passafe_dashboard.live.barrier_gaps import BarrierGaps, Gap
from passafe_dashboard.live.driver_seat import DriverSeat
from passafe_dashboard.live.run_state import RunState
from passafe_dashboard.live.topic_monitor import TopicMonitor

TOPICS_READ: Final[tuple[Topic, ...]] = (TICK, STATE, LEASE, HEALTH, EVENT, SCENARIO, LINK_EVENT, LINK_STATE)
"""Topics of the feed; it ignores messages of others."""

[PLANT] = STATE.publishers
"""Process whose sessions are runs."""


class ReceivedEvent(NamedTuple):
    """An event that came in.

    Attributes:
        number: Counts events from 0.
        source: Process that published it.
        severity: Its severity.
        text: Its text.
        received_ns: Monotonic time at which it came in, ns.
    """

    number: int
    source: str
    severity: str
    text: str
    received_ns: int


class ProcessReport(NamedTuple):
    """Last Health of a process and the monotonic time at which it came in, ns."""

    health: Health
    received_ns: int


def scenario_id(scenario: Scenario | None) -> str:
    """Return the digest of a scenario: a page drawn for another one is out of date."""
    if scenario is None:
        return "none"
    return sha256(scenario.model_dump_json().encode()).hexdigest()[:16]


class Feed:
    """State of the page: what its charts, tables and texts show.

    Attributes:
        scenario: Effective configuration, or ``None`` while it is not known.
        scenario_id: Digest of it.
        layout: Its columns.
        info: ScenarioInfo of the run, once received.
        run: State of the run; a restarted plant begins another, a restarted filter does not.
        processes: Last Health of each process.
        events: Newest events.
        topic_monitors: Monitor of each topic of each source.
        refused: Messages refused before they were counted, by topic.
        links: Newest states of the links.
        lease: Newest lease of the operator.
        lease_since_ns: When it changed hands or device, this process's monotonic clock.
        seat: Seat of the page that drives.
        session: State of the demo's session of runs, as JSON; ``None``: no demo supervises this system.
        end: Why the run is over, once it is.
        capacity: Rows kept for charts.

    Args:
        scenario: Configuration to start with; a ScenarioInfo replaces it.
        frame_hz: Rows a second kept for charts.
        history_s: Seconds of plant time kept for charts.
        events_kept: Events kept.
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        *,
        frame_hz: int = 30,
        history_s: float = 30.0,
        events_kept: int = 50,
    ) -> None:
        self.scenario: Scenario | None = None
        self.scenario_id = scenario_id(None)
        self.layout = ColumnLayout(barriers=(), levels=())
        self._barrier_values: BarrierValues | None = None
        self._barrier_gaps: BarrierGaps | None = None
        self.info: ScenarioInfo | None = None
        self.session: dict[str, Any] | None = None
        self.end: str | None = None
        self.processes: dict[str, ProcessReport] = {}
        self.events: deque[ReceivedEvent] = deque(maxlen=events_kept)
        self.topic_monitors: dict[tuple[str, str], TopicMonitor] = {}
        self.refused: dict[str, int] = {}
        self.links = NewestLinkStates()
        self.lease: OperatorLease | None = None
        self.lease_since_ns = 0
        self.seat = DriverSeat()
        self._events_received = 0
        self._epochs: dict[str, int] = {}
        self._bin_ns = NS_PER_S // frame_hz
        self.capacity = round(history_s * frame_hz)
        self._handlers: dict[type[Message], Callable[[Header, Any, int], None]] = {
            FilterTick: self._push_tick,
            PlantState: self._push_state,
            Health: self._push_health,
            Event: self._push_event,
            ScenarioInfo: self._push_scenario,
            LinkEvent: self._push_link_event,
            LinkState: self.links.receive,
            OperatorLease: self._push_lease,
        }
        self.run = self._new_run(0)
        if scenario is not None:
            self._adopt(scenario)

    def push(self, header: Header, body: Message, received_ns: int) -> None:
        """Update the state with a message.

        Args:
            header: Its header.
            body: Its body.
            received_ns: This process's monotonic clock at its arrival, ns.
        """
        if self._accept(header, body, received_ns):
            self._handlers[type(body)](header, body, received_ns)

    def push_partial(self, header: Header, body: FilterTick | PlantState, received_ns: int) -> None:
        """Update charts, counts and lowest values with a message that was decoded for these only."""
        if self._accept(header, body, received_ns):
            self._add(header, body)

    def _accept(self, header: Header, body: Message, received_ns: int) -> bool:
        """Count an arrival; return whether the message is valid. A reordered one is: it may hold the worst value."""
        if type(body) not in self._handlers:
            return False
        topic = TOPIC_OF_BODY[type(body)]
        key = (header.source, topic.name)
        monitor = self.topic_monitors.get(key)
        if monitor is None:
            if header.source not in topic.publishers:
                self.refuse(topic)
                return False
            monitor = self.topic_monitors[key] = TopicMonitor(topic, header.source)
        return monitor.receive(header, received_ns)

    def refuse(self, topic: Topic) -> None:
        """Count a message that could not be decoded, or whose source may not publish its topic."""
        self.refused[topic.name] = self.refused.get(topic.name, 0) + 1

    @property
    def health(self) -> tuple[TopicHealth, ...]:
        """Messages, gaps and refusals of every topic read, over all publishers."""
        counts = {topic.name: [0, 0, self.refused.get(topic.name, 0)] for topic in TOPICS_READ}
        for (_, name), monitor in self.topic_monitors.items():
            for index, number in enumerate((monitor.received, monitor.gaps, monitor.refused)):
                counts[name][index] += number
        return tuple(TopicHealth(name, *numbers) for name, numbers in counts.items())

    def finish(self, reason: str) -> None:
        """End the run for a reason; the page keeps its last state."""
        self.end = reason

    def measured_h(self, state: PlantState) -> list[float] | None:
        """Return h of every barrier where the robot is; ``None`` for a state of another scenario."""
        if not self.layout.fits(state):
            return None
        return [] if self._barrier_values is None else self._barrier_values.h(state.actual_x, state.plant_ns / NS_PER_S)

    def gaps(self, x: Sequence[float], time_ns: int) -> list[Gap]:
        """Return the distance to every barrier at a state; none for a state of another scenario."""
        if self._barrier_gaps is None or len(x) < self.layout.states:
            return []
        return self._barrier_gaps.read(x, time_ns / NS_PER_S)

    def displacements_m(self, state: PlantState) -> dict[str, tuple[float, float]]:
        """Return how far each outline that moves is from where it was drawn, m, by the name of its table."""
        return {} if self._barrier_values is None else self._barrier_values.displacements_m(state.plant_ns / NS_PER_S)

    def _new_run(self, number: int) -> RunState:
        period_ns = 0 if self.scenario is None else round(self.scenario.dt_s * NS_PER_S)
        return RunState(number, self.layout, period_ns=period_ns, bin_ns=self._bin_ns, capacity=self.capacity)

    def _begin_run(self) -> None:
        self.run = self._new_run(self.run.number + 1)

    def _adopt(self, scenario: Scenario) -> None:
        self._barrier_values = BarrierValues(scenario)
        self._barrier_gaps = BarrierGaps(scenario)
        self.scenario = scenario
        self.scenario_id = scenario_id(scenario)
        self.layout = ColumnLayout.of(scenario)
        self._begin_run()

    def _check_session(self, header: Header) -> None:
        known = self._epochs.get(header.source)
        if known != header.epoch:
            self._epochs[header.source] = header.epoch
            if known is not None and header.source == PLANT:
                self._begin_run()
            elif known is not None:
                self.run.tick = None  # its ticks are numbered from 0 again

    def _add(self, header: Header, body: FilterTick | PlantState) -> None:
        self._check_session(header)
        if isinstance(body, FilterTick):
            self.run.add_tick(body)
        else:
            h = self.measured_h(body)
            self.run.add_state(body, h)
            if h and min(h) < 0.0 and not body.true_x:
                self._add_possible(body)

    def _add_possible(self, state: PlantState) -> None:
        """Add what h may be where a state that was read with an error is out of a barrier."""
        values, at_s = self._barrier_values, state.plant_ns / NS_PER_S
        if values is not None and not values.is_exact:
            self.run.add_possible_h(Extremum(min(values.possible_h(state.x, at_s)), at_s))

    def _push_tick(self, header: Header, tick: FilterTick, _received_ns: int) -> None:
        self._add(header, tick)
        self.run.show_tick(tick)

    def _push_state(self, header: Header, state: PlantState, _received_ns: int) -> None:
        self._add(header, state)
        self.run.show_state(state)

    def _push_health(self, header: Header, health: Health, received_ns: int) -> None:
        self.processes[header.source] = ProcessReport(health, received_ns)

    def _push_event(self, header: Header, event: Event, received_ns: int) -> None:
        self._add_event(header.source, event.severity, event.text, received_ns)

    def _push_lease(self, _header: Header, lease: OperatorLease, received_ns: int) -> None:
        known = self.lease
        if known is None or (known.number, known.holder, known.device) != (lease.number, lease.holder, lease.device):
            self.lease_since_ns = received_ns
        self.lease = lease

    def _push_link_event(self, _header: Header, event: LinkEvent, _received_ns: int) -> None:
        self.run.add_link_event(event)

    def _push_scenario(self, header: Header, info: ScenarioInfo, received_ns: int) -> None:
        if info == self.info:  # the filter repeats it for those that come later
            return
        self.info = info
        try:
            scenario = Scenario.model_validate_json(info.scenario_json)
            if scenario != self.scenario:
                self._adopt(scenario)
        except ValidationError as error:
            self._refuse_scenario(header, f"{error.error_count()} errors", received_ns)
        except PassafeError as error:
            self._refuse_scenario(header, str(error), received_ns)

    def _refuse_scenario(self, header: Header, reason: str, received_ns: int) -> None:
        self._add_event(header.source, "error", f"its scenario does not fit this dashboard: {reason}", received_ns)

    def _add_event(self, source: str, severity: str, text: str, received_ns: int) -> None:
        self.events.append(ReceivedEvent(self._events_received, source, severity, text, received_ns))
        self._events_received += 1
