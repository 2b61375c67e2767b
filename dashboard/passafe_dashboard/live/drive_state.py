"""Turn who drives into JSON values, for ``now`` in each frame and for the pages that may drive."""

from typing import Any, Final

from passafe_protocol.messages import WhoDrives
from passafe_services.scenarios.driving_axes import DrivingAxes
from passafe_services.scenarios.schema import Scenario

from passafe_dashboard.live.driver_seat import DEVICE
from passafe_dashboard.live.feed import Feed

NS_PER_MS: Final = 1e6


def driver_json(feed: Feed) -> dict[str, Any] | None:
    """Return who drives, a page or an operator's device, and since when on the server's clock; null for nobody."""
    seat, other = feed.seat, other_operator(feed)
    if seat.page:
        return {"page": str(seat.page), "device": DEVICE, "since_ms": seat.since_ns / NS_PER_MS}
    if feed.lease is None or not feed.lease.holder or (seat.who == WhoDrives.NOBODY and not other):
        return None
    return {"page": None, "device": feed.lease.device, "since_ms": feed.lease_since_ns / NS_PER_MS}


def drive_json(feed: Feed) -> dict[str, Any]:
    """Return who drives and how many pages may."""
    return {"driver": driver_json(feed), "pages": feed.seat.pages}


def other_operator(feed: Feed) -> str:
    """Return the device of the operator that holds the lease, if it follows no page; empty otherwise."""
    lease, scenario = feed.lease, feed.scenario
    if lease is None or not lease.holder:
        return ""
    own = {DEVICE} if scenario is None else {DEVICE, scenario.operator.source.kind}
    return "" if lease.device in own else lease.device


def drive_setup(scenario: Scenario | None) -> dict[str, Any] | None:
    """Return what a page needs to drive a scenario's robot; null while no scenario is known.

    Returns:
        ``axes``: number of inputs, ``full``: largest |u_h| of each, in units ``unit``, ``pairs``: the inputs of each
        joystick, and ``names``: its name.
    """
    if scenario is None:
        return None
    axes = DrivingAxes.of(scenario)
    return {
        "axes": len(axes.full),
        "full": axes.full,
        "unit": scenario.plant.robot_model.input_unit,
        "pairs": axes.planes,
        "names": axes.names,
    }
