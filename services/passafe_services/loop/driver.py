"""Live driver: steps one node at a fixed rate, receives and publishes its messages and reports its health."""

import time
from collections.abc import Callable, Mapping, Sequence
from time import monotonic_ns
from typing import Final

from passafe_protocol.errors import ProtocolError
from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import Event, Health, LinkConfig, Message
from passafe_protocol.topics import EVENT, HEALTH, LINK_CONFIG, LINK_EVENT, LINK_STATE, SCENARIO, Topic

from passafe.errors import PassafeError
from passafe_services.foreign_errors import words_of
from passafe_services.loop.bounded_reading import DRAIN_SHARE, READ_SHARE, BoundedReading
from passafe_services.loop.bus import Bus
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.inlet import Inlet, inlets_of, pop_inbox, require_links
from passafe_services.loop.link_control import LinkControl
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.loop.realtime import yield_processor
from passafe_services.loop.shared_scenario import SharedScenario
from passafe_services.loop.stop import Stop, StopReason
from passafe_services.node import Node

HEALTH_PERIOD_NS: Final = 1_000_000_000
OVERLOAD: Final = 0.05
"""Share of skipped steps above which a process reports an overload."""

_NS_PER_S: Final = 1e9


class Driver:
    """Runs one node with its inlets and its outlet."""

    def __init__(
        self,
        node: Node,
        bus: Bus,
        links: Mapping[str, LinkSettings],
        changes: Sequence[LinkChange],
        epoch: int,
        log: RateLimitedLog,
        health: HealthReporter | None = None,
        shared: SharedScenario | None = None,
    ) -> None:
        """Declare the readers and publishers of the node.

        Args:
            node: The node.
            bus: The open session.
            links: Settings of injected links by name; those at other nodes are ignored.
            changes: Scheduled changes of these settings.
            epoch: Session number of the published messages.
            log: Log that limits the rate of repeated messages.
            health: Reports the health of the loop to what supervises the process.
            shared: Repeats or compares the scenario.

        Raises:
            LinkNameError: ``links`` or ``changes`` name a link that does not exist.
        """
        require_links(change.link for change in changes)
        self._node = node
        self._bus = bus
        self._router = bus.router
        self._log = log
        self._shared = SharedScenario(node.name, "", bus) if shared is None else shared
        self._inlets = inlets_of(node, links)
        self._reading = BoundedReading([(inlet, bus.reader(inlet.topic)) for inlet in self._inlets])
        self._configs, self._config_reader = Inlet(LINK_CONFIG), bus.reader(LINK_CONFIG)
        sources = {inlet.link.name: inlet for inlet in self._inlets if inlet.link is not None}
        linked = [inlet.link for inlet in self._inlets if inlet.link is not None]
        self._links = LinkControl(linked, changes, lambda link: sources[link.name].sources)
        self._outlet = Outlet(bus, node.name, epoch, health)
        self._scheduled_ns = self._started_ns = monotonic_ns()
        self._drain_ns = self._read_ns = 0

    @property
    def withheld(self) -> int:
        """Invalid messages of the node, which were not sent."""
        return self._outlet.withheld

    @property
    def outlet(self) -> Outlet:
        """Outlet by which the process publishes."""
        return self._outlet

    def run(
        self,
        pace: Pace,
        stop: Stop,
        end_ns: int | None,
        finished: Callable[[], bool],
        collect: Callable[[], object],
    ) -> StopReason:
        """Step the node until there is a reason to stop, and return that reason.

        An error ends it as well; what it is stands in the log.

        Args:
            pace: Schedule of the steps.
            stop: Stop request, checked before each step.
            end_ns: Monotonic time from which no step is due any more, ns; ``None``: no limit.
            finished: Called before each step; true ends the loop.
            collect: Called once a second, after a step.
        """
        self._drain_ns, self._read_ns = (round(share * pace.period_ns) for share in (DRAIN_SHARE, READ_SHARE))
        self._publish(EVENT, Event("info", "started"))
        try:
            return self._loop(pace, stop, end_ns, finished, collect)
        except Exception as error:
            self._report_error(f"after {pace.steps} steps", error)
            raise

    def reporting_errors(self, when: str, call: Callable[[], object]) -> None:
        """Call what belongs to the node; what it raises stands in the log, too.

        Args:
            when: When in the life of the process that is, for people.
            call: Is called once.
        """
        try:
            call()
        except Exception as error:
            self._report_error(when, error)
            raise

    def _report_error(self, when: str, error: Exception) -> None:
        words = " ".join(str(error).split()) if isinstance(error, PassafeError) else words_of(error)
        self.report("error", "error", f"ended by an error {when}: {words}")

    def _loop(
        self,
        pace: Pace,
        stop: Stop,
        end_ns: int | None,
        finished: Callable[[], bool],
        collect: Callable[[], object],
    ) -> StopReason:
        health_due_ns = pace.due_ns + HEALTH_PERIOD_NS
        reported_ns, reported_steps, reported_skipped = pace.due_ns, 0, 0
        while True:
            reason = _reason_to_end(pace, stop, end_ns, finished)
            if reason is not None:
                break
            wait_ns = pace.due_ns - monotonic_ns()
            if wait_ns > 0:
                time.sleep(wait_ns / _NS_PER_S)
            else:
                yield_processor()
            now_ns = monotonic_ns()
            self._step(pace.begin(now_ns))
            if now_ns >= health_due_ns:
                self._publish_health(pace, (pace.steps - reported_steps) * _NS_PER_S / (now_ns - reported_ns))
                self._check_router()
                self._check_admission()
                self._share_scenario()
                self._check_overload(pace.steps - reported_steps, pace.skipped - reported_skipped)
                reported_ns, reported_steps, reported_skipped = now_ns, pace.steps, pace.skipped
                health_due_ns = now_ns + HEALTH_PERIOD_NS
                collect()
            pace.end(monotonic_ns())
        for state in self._links.last_states():
            self._publish(LINK_STATE, state)
        elapsed_ns = max(1, monotonic_ns() - reported_ns)
        self._publish_health(pace, (pace.steps - reported_steps) * _NS_PER_S / elapsed_ns)
        self.report("end", "info", f"ended by {reason.value} after {pace.steps} steps")
        return reason

    def report(self, kind: str, severity: str, text: str) -> None:
        """Log a message on standard error and publish it as an event, within the limits of ``RateLimitedLog``."""
        event = self._log.report(kind, severity, text, monotonic_ns())
        if event is not None:
            self._publish(EVENT, event)

    def _step(self, scheduled_ns: int) -> None:
        configs = self._config_reader.drain()
        self._reading.drain(monotonic_ns() + self._drain_ns, monotonic_ns)
        # Read the clock after draining: even if this process was suspended, no message is received before it was sent.
        now_ns = monotonic_ns()
        self._scheduled_ns = scheduled_ns
        self._started_ns = now_ns
        self._configure(now_ns, configs)
        if now_ns >= self._links.due_ns:
            self._links.advance(now_ns)
        for inlet, data in self._reading.messages(now_ns + self._read_ns, monotonic_ns):
            self._receive(inlet, now_ns, data)
        for topic, body in self._node.step(scheduled_ns, pop_inbox(self._inlets, now_ns)):
            self._publish(topic, body)
        if now_ns >= self._links.due_ns:
            for state in self._links.due_states(now_ns):
                self._publish(LINK_STATE, state)

    def _configure(self, now_ns: int, configs: Sequence[bytes]) -> None:
        for data in configs:
            self._receive(self._configs, now_ns, data)
        for received in self._configs.pop_received(now_ns):
            if isinstance(received.body, LinkConfig):
                self._links.configure(received.header, received.body)

    def _receive(self, inlet: Inlet, now_ns: int, data: bytes) -> None:
        outcome = inlet.receive_bytes(now_ns, data)
        if isinstance(outcome, ProtocolError):
            kind = f"refused {type(outcome).__name__} {inlet.topic.name}"
            self.report(kind, "warning", f"refused {outcome}")
            return
        for event in outcome:
            self._publish(LINK_EVENT, event)

    def _publish(self, topic: Topic, body: Message | Callable[[], Message]) -> None:
        error = self._outlet.publish(topic, body, scheduled_ns=self._scheduled_ns, started_ns=self._started_ns)
        if topic is SCENARIO and not callable(body):
            self._shared.keep(body)
        if error is not None and topic is not EVENT:
            self.report(f"withheld {topic.name}", "error", f"withheld {error}")

    def _check_router(self) -> None:
        router = self._bus.router
        if not router or router == self._router:
            return
        if self._router:
            text = "the router was restarted: messages sent in between were not delivered"
            self.report("router", "warning", text)
        self._router = router

    def _check_admission(self) -> None:
        refusal = self._bus.refusal
        if refusal:
            self.report("admission", "error", refusal)

    def _share_scenario(self) -> None:
        if self._shared.repeated is not None:
            self._publish(SCENARIO, self._shared.repeated)
        difference = self._shared.difference()
        if difference:
            self.report("scenario", "error", difference)

    def _check_overload(self, steps: int, skipped: int) -> None:
        if skipped > OVERLOAD * (steps + skipped):
            share = f"{skipped} of the last {steps + skipped} steps"
            self.report("overload", "warning", f"skipped {share}: machine overloaded, try a lower rate")

    def _publish_health(self, pace: Pace, rate_hz: float) -> None:
        topics = tuple(inlet.health for inlet in self._inlets)
        late_us = pace.pop_max_lateness_ns() / 1e3
        self._publish(HEALTH, Health(rate_hz, pace.steps, pace.overruns, pace.skipped, late_us, topics))


def _reason_to_end(pace: Pace, stop: Stop, end_ns: int | None, finished: Callable[[], bool]) -> StopReason | None:
    if stop.reason is not None:
        return stop.reason
    if end_ns is not None and pace.due_ns >= end_ns:
        return StopReason.DURATION
    return StopReason.FINISHED if finished() else None
