"""One node in one process, at a fixed rate, over the bus."""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from time import monotonic_ns
from typing import Final

from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import LinkSettings

from passafe_services.loop.bus import open_bus
from passafe_services.loop.driver import Driver
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.realtime import own_processor, quiet_collector, request_realtime, step_aside
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.stop import StopReason, stop_requests
from passafe_services.node import Node

_NS_PER_S: Final = 1e9


@dataclass(frozen=True, kw_only=True, slots=True)
class LiveReport:
    """What became of a live run of one node.

    Attributes:
        steps: Steps made.
        overruns: Steps that ended after the next was due.
        steps_skipped: Steps left out because the loop had fallen behind.
        withheld: Messages that the node made and that were not valid.
        reason: Why it ended.
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
    links: Mapping[str, LinkSettings],
    link_changes: Sequence[LinkChange] = (),
    duration_s: float | None = None,
    epoch: int | None = None,
    lifeline: bool = False,
    finished: Callable[[], bool] | None = None,
) -> LiveReport:
    """Step a node against the clock until somebody ends it; main thread only.

    A node's ``now_ns`` is when its step was due, on a grid of whole periods; when the step really began is in
    the header of all that it publishes. ``received_ns`` of a message is the time of the step that found it, or when it
    came out of its link. So a log says exactly what the node was stepped with.

    Args:
        node: The node.
        rate_hz: Steps per second.
        endpoint: Where the router listens.
        links: Settings of injected links by name; those at other nodes are passed over.
        link_changes: Changes of these settings, planned; those at other nodes are passed over too.
        duration_s: How long to run; ``None``: until somebody ends it.
        epoch: Session number of what is published; the wall clock in ns if not given.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).
        finished: Asked before each step whether the node wants no more.

    Returns:
        Counts, and why it ended: a signal, the end of the lifeline or of the duration, or ``finished``.

    Raises:
        BusError: If there is no router.
        LinkNameError: If ``links`` or ``link_changes`` name a link that does not exist.
    """
    notices = RateLimitedLog()
    with ExitStack() as stack:
        stop = stack.enter_context(stop_requests(lifeline=lifeline))
        refusal = request_realtime()
        if refusal is None:
            own_processor(node.name)
        bus = stack.enter_context(open_bus(endpoint))
        driver = Driver(node, bus, links, link_changes, time.time_ns() if epoch is None else epoch, notices)
        if refusal is not None:
            driver.say("realtime", "warning", refusal)
        announce_ready(node.name)
        step_aside()
        collect = stack.enter_context(quiet_collector())
        request_realtime()
        pace = Pace(monotonic_ns() + round(_NS_PER_S / rate_hz), rate_hz)
        end_ns = None if duration_s is None else pace.due_ns + round(_NS_PER_S * duration_s)
        reason = driver.run(pace, stop, end_ns, finished or _never, collect)
        return LiveReport(
            steps=pace.steps,
            overruns=pace.overruns,
            steps_skipped=pace.missed,
            withheld=driver.withheld,
            reason=reason,
        )


def _never() -> bool:
    return False
