"""Runs one node in one process, at a fixed rate, over the bus."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from time import monotonic_ns
from typing import Final, NoReturn

from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings

from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.driver import Driver
from passafe_services.loop.hang_watch import HANG_S, SLOW_S, Call, hang_watch
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.realtime import (
    lower_priority,
    paused_garbage_collection,
    pin_to_processor,
    request_realtime,
)
from passafe_services.loop.receipts import Receipts
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.shared_scenario import SharedScenario
from passafe_services.loop.stop import StopReason, stop_requests
from passafe_services.node import Node

HUNG: Final = 2
"""Exit code of a process that ends because a call hangs."""

_NS_PER_S: Final = 1e9


@dataclass(frozen=True, kw_only=True, slots=True)
class LiveReport:
    """Outcome of a live run of one node.

    Attributes:
        steps: Steps executed.
        overruns: Steps that ended after the next was due.
        steps_skipped: Steps skipped to catch up.
        withheld: Invalid messages of the node, which were not sent.
        reason: Reason for the end.
    """

    steps: int
    overruns: int
    steps_skipped: int
    withheld: int
    reason: StopReason


def run_live(
    node: Node,
    *,
    rate_hz: float,
    endpoint: RouterEndpoint,
    robot: str = DEFAULT_ROBOT,
    links: Mapping[str, LinkSettings],
    link_changes: Sequence[LinkChange] = (),
    duration_s: float | None = None,
    epoch: int | None = None,
    lifeline: bool = False,
    finished: Callable[[], bool] | None = None,
    begun: Callable[[], object] = lambda: None,
    ended: Callable[[], object] = lambda: None,
    waits_in: Callable[[], Call | None] | None = None,
    health: HealthReporter | None = None,
    scenario_json: str = "",
) -> LiveReport:
    """Step a node in real time until it is stopped; main thread only.

    The ``now_ns`` of a step is the time at which it was due, on a grid of whole periods; the time at which it began is
    in the headers of its messages. ``received_ns`` of a message is the time of the step that received it, or the time
    at which it left its link. A log therefore contains the exact arguments of every step.

    Args:
        node: The node.
        rate_hz: Steps per second.
        endpoint: Address of the router.
        robot: Robot whose node it is.
        links: Settings of injected links by name; those at other nodes are ignored.
        link_changes: Scheduled changes of these settings; those at other nodes are ignored.
        duration_s: Duration of the run, s; ``None``: until it is stopped.
        epoch: Session number of the published messages; the wall clock in ns if not given.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).
        finished: Called before each step; true ends the run.
        begun: Called once on the bus, before the process is ready.
        ended: Called after the last step, also after an error, before the recorder is waited for.
        waits_in: Returns the call of somebody's code that the loop waits for, if any: one that does not return ends the
            process, with an event that says so.
        health: Reports the health of the loop to what supervises the process.
        scenario_json: Scenario of the process, to be compared with the filter's; empty: it is not.

    Returns:
        Counts, and the reason for the end: a signal, the end of the lifeline or of the duration, or ``finished``.

    Raises:
        BusError: There is no router.
        LinkNameError: ``links`` or ``link_changes`` name a link that does not exist.
    """
    log = RateLimitedLog()
    with ExitStack() as stack:
        stop = stack.enter_context(stop_requests(lifeline=lifeline))
        refusal = request_realtime()
        if refusal is None:
            pin_to_processor(node.name)
        bus = stack.enter_context(open_bus(endpoint, robot=robot))
        session = time.time_ns() if epoch is None else epoch
        shared = SharedScenario(node.name, scenario_json, bus)
        driver = Driver(node, bus, links, link_changes, session, log, health, shared)
        receipts = Receipts(bus)
        if refusal is not None:
            driver.report("realtime", "warning", refusal)
        stack.callback(_await_recorder, driver, receipts)  # nor is what led to an error lost
        slow = stack.enter_context(hang_watch(waits_in, partial(_end_hanging, driver, receipts, bus)))
        driver.reporting_errors("before its first step", begun)
        announce_ready(node.name)
        lower_priority()
        collect = stack.enter_context(paused_garbage_collection())
        stack.callback(lower_priority)  # the end takes long, and others' loops may run on the same processor
        request_realtime()
        pace = Pace(monotonic_ns() + round(_NS_PER_S / rate_hz), rate_hz)
        end_ns = None if duration_s is None else pace.due_ns + round(_NS_PER_S * duration_s)
        stack.callback(driver.reporting_errors, "at its end", ended)
        reason = driver.run(
            pace, stop, end_ns, finished or (lambda: False), partial(_once_a_second, driver, collect, slow)
        )
        return LiveReport(
            steps=pace.steps,
            overruns=pace.overruns,
            steps_skipped=pace.skipped,
            withheld=driver.withheld,
            reason=reason,
        )


def _once_a_second(driver: Driver, collect: Callable[[], object], slow: list[str]) -> None:
    """Collect garbage, and report calls that were slow: an overload would be blamed on the machine."""
    collect()
    if slow:
        calls = ", ".join(sorted(set(slow)))
        slow.clear()
        driver.report("slow", "warning", f"{calls}: got no return for {SLOW_S:g} s, allowed to return at once")


def _await_recorder(driver: Driver, receipts: Receipts) -> None:
    """Wait until the recorder has the last messages."""
    unrecorded = receipts.wait_for(driver.outlet)
    if unrecorded:
        driver.report("unrecorded", "warning", f"the recorder did not take the last messages of {unrecorded} topics")


def _end_hanging(driver: Driver, receipts: Receipts, bus: Bus, call: str) -> NoReturn:
    """End the process whose main thread waits in a call: nothing else could end it."""
    driver.report("hang", "error", f"ended: {call}: got no return for {HANG_S:g} s, allowed to return at once")
    _await_recorder(driver, receipts)
    bus.close()  # sends what waits to be sent
    os._exit(HUNG)
