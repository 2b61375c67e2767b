"""Drives one node against the clock: what came in, the step, what goes out, and how it fares."""

import time
from collections.abc import Callable, Mapping, Sequence
from time import monotonic_ns
from typing import Final

from passafe_protocol.errors import ProtocolError
from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import Event, Health, LinkConfig, Message
from passafe_protocol.topics import EVENT, HEALTH, LINK_CONFIG, LINK_EVENT, LINK_STATE, Topic

from passafe_services.loop.bus import Bus
from passafe_services.loop.inlet import Inlet, inlets_of, require_links, take_all
from passafe_services.loop.link_control import LinkControl
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.loop.realtime import give_way
from passafe_services.loop.stop import Stop, StopReason
from passafe_services.node import Node

HEALTH_PERIOD_NS: Final = 1_000_000_000
BEHIND: Final = 0.05
"""Share of steps left out from which a process says that it does not keep up."""

_NS_PER_S: Final = 1e9


class Driver:
    """One node, its inlets and its outlet.

    Attributes:
        withheld: Messages that were not valid and therefore not sent.
    """

    def __init__(
        self,
        node: Node,
        bus: Bus,
        links: Mapping[str, LinkSettings],
        changes: Sequence[LinkChange],
        epoch: int,
        notices: RateLimitedLog,
    ) -> None:
        """Declare what the node reads and what it sends.

        Args:
            node: The node.
            bus: The session, open.
            links: Settings of injected links by name; those at other nodes are passed over.
            changes: Changes of these settings, planned.
            epoch: Session number of what is published.
            notices: Decides how often the same thing is said.

        Raises:
            LinkNameError: If ``links`` or ``changes`` name a link that does not exist.
        """
        require_links(change.link for change in changes)
        self._node = node
        self._bus = bus
        self._router = bus.router
        self._notices = notices
        self._inlets = inlets_of(node, links)
        self._readers = tuple((inlet, bus.reader(inlet.topic)) for inlet in self._inlets)
        self._configs, self._config_reader = Inlet(LINK_CONFIG), bus.reader(LINK_CONFIG)
        sources = {inlet.link.name: inlet for inlet in self._inlets if inlet.link is not None}
        linked = [inlet.link for inlet in self._inlets if inlet.link is not None]
        self._links = LinkControl(linked, changes, lambda link: sources[link.name].sources)
        self._outlet = Outlet(bus, node.name, epoch)
        self._scheduled_ns = self._started_ns = monotonic_ns()

    @property
    def withheld(self) -> int:
        """Messages that were not valid and therefore not sent."""
        return self._outlet.withheld

    def run(
        self,
        pace: Pace,
        stop: Stop,
        end_ns: int | None,
        finished: Callable[[], bool],
        collect: Callable[[], None],
    ) -> StopReason:
        """Step until there is a reason not to; returns it.

        Args:
            pace: When steps are due.
            stop: Asked before each step.
            end_ns: Monotonic time from which no step is due any more, ns; ``None``: there is none.
            finished: Asked before each step whether the node wants no more.
            collect: Called once a second, after a step.
        """
        health_due_ns = pace.due_ns + HEALTH_PERIOD_NS
        told_ns, told_steps, told_missed = pace.due_ns, 0, 0
        self._publish(EVENT, Event("info", "started"))
        while True:
            reason = _reason_to_end(pace, stop, end_ns, finished)
            if reason is not None:
                break
            wait_ns = pace.due_ns - monotonic_ns()
            if wait_ns > 0:
                time.sleep(wait_ns / _NS_PER_S)
            else:
                give_way()
            now_ns = monotonic_ns()
            self._step(pace.begin(now_ns))
            if now_ns >= health_due_ns:
                self._tell_health(pace, (pace.steps - told_steps) * _NS_PER_S / (now_ns - told_ns))
                self._look_for_router()
                self._admit_being_behind(pace.steps - told_steps, pace.missed - told_missed)
                told_ns, told_steps, told_missed = now_ns, pace.steps, pace.missed
                health_due_ns = now_ns + HEALTH_PERIOD_NS
                collect()
            pace.end(monotonic_ns())
        for state in self._links.last_states():
            self._publish(LINK_STATE, state)
        elapsed_ns = max(1, monotonic_ns() - told_ns)
        self._tell_health(pace, (pace.steps - told_steps) * _NS_PER_S / elapsed_ns)
        self.say("end", "info", f"ended by {reason.value} after {pace.steps} steps")
        return reason

    def say(self, kind: str, severity: str, text: str) -> None:
        """Say something on standard error and as an event, within the limits of ``RateLimitedLog``."""
        event = self._notices.notice(kind, severity, text, monotonic_ns())
        if event is not None:
            self._publish(EVENT, event)

    def _step(self, scheduled_ns: int) -> None:
        configs = self._config_reader.drain()
        came = [reader.drain() for _, reader in self._readers]
        # Only now: however long this process was held up, nothing has come before it was sent.
        now_ns = monotonic_ns()
        self._scheduled_ns = scheduled_ns
        self._started_ns = now_ns
        self._configure(now_ns, configs)
        if now_ns >= self._links.due_ns:
            self._links.advance(now_ns)
        for (inlet, _), messages in zip(self._readers, came, strict=True):
            for data in messages:
                self._read(inlet, now_ns, data)
        for topic, body in self._node.step(scheduled_ns, take_all(self._inlets, now_ns)):
            self._publish(topic, body)
        if now_ns >= self._links.due_ns:
            for state in self._links.due_states(now_ns):
                self._publish(LINK_STATE, state)

    def _configure(self, now_ns: int, configs: Sequence[bytes]) -> None:
        for data in configs:
            self._read(self._configs, now_ns, data)
        for received in self._configs.take(now_ns):
            if isinstance(received.body, LinkConfig):
                self._links.configure(received.header, received.body)

    def _read(self, inlet: Inlet, now_ns: int, data: bytes) -> None:
        told = inlet.read(now_ns, data)
        if isinstance(told, ProtocolError):
            self.say(f"refused {inlet.topic.name}", "warning", f"refused {told}")
            return
        for event in told:
            self._publish(LINK_EVENT, event)

    def _publish(self, topic: Topic, body: Message | Callable[[], Message]) -> None:
        error = self._outlet.publish(topic, body, scheduled_ns=self._scheduled_ns, started_ns=self._started_ns)
        if error is not None and topic is not EVENT:
            self.say(f"withheld {topic.name}", "error", f"withheld {error}")

    def _look_for_router(self) -> None:
        router = self._bus.router
        if not router or router == self._router:
            return
        if self._router:
            text = "the router was started again: what was sent while there was none did not arrive"
            self.say("router", "warning", text)
        self._router = router

    def _admit_being_behind(self, made: int, left_out: int) -> None:
        if left_out > BEHIND * (made + left_out):
            steps = f"{left_out} of the last {made + left_out} steps"
            self.say("behind", "warning", f"left out {steps}: too much for this machine, try a lower rate")

    def _tell_health(self, pace: Pace, rate_hz: float) -> None:
        topics = tuple(inlet.health for inlet in self._inlets)
        late_us = pace.take_worst_late_ns() / 1e3
        self._publish(HEALTH, Health(rate_hz, pace.steps, pace.overruns, pace.missed, late_us, topics))


def _reason_to_end(pace: Pace, stop: Stop, end_ns: int | None, finished: Callable[[], bool]) -> StopReason | None:
    if stop.reason is not None:
        return stop.reason
    if end_ns is not None and pace.due_ns >= end_ns:
        return StopReason.DURATION
    return StopReason.FINISHED if finished() else None
