"""Describe the scene of a run for the page: outlines in the plane, or joints with their limits."""

from typing import Any

from passafe_services.scenarios.barrier_kinds.coordinate_limits import CoordinateLimit
from passafe_services.scenarios.barrier_kinds.outline import Outline

from passafe_dashboard.run_record.signals import SignalLayout


def scene_payload(layout: SignalLayout, unit: str) -> dict[str, Any]:
    """Return the scene as JSON values.

    Args:
        layout: Signals of the run.
        unit: Unit of a coordinate of the position.
    """
    if layout.points:
        return {"kind": "plane", "points": layout.points, "outlines": _outlines(layout), **_body(layout)}
    return {"kind": "joints", "unit": unit, "joints": [_joint(layout, i) for i in range(layout.coordinates)]}


def _body(layout: SignalLayout) -> dict[str, Any]:
    """Return the body of a robot that has one: its outline, the column of its angle, and links between points."""
    drawn = layout.drawn
    if drawn is None:
        return {}
    heading = f"q_{2 * drawn.count}" if drawn.has_heading else None
    return {"outline": drawn.outline, "heading": heading, "links": drawn.links, "arrows": drawn.pushes is None}


def _outlines(layout: SignalLayout) -> list[dict[str, Any]]:
    """Return each outline once, where a barrier holds for several points, with the numbers of its barriers."""
    numbers: dict[Outline, list[int]] = {}
    for i, barrier in enumerate(layout.barriers):
        if barrier.outline is not None:
            numbers.setdefault(barrier.outline, []).append(i)
    return [
        {
            "names": [layout.barriers[i].name for i in barriers],
            "barriers": barriers,
            "border": outline.border,
            "unsafe": outline.unsafe,
            "bounded": outline.is_bounded,
            "closed": outline.is_closed,
            "moving": barriers[0] if outline.motion is not None else None,
        }
        for outline, barriers in numbers.items()
    ]


def _joint(layout: SignalLayout, index: int) -> dict[str, Any]:
    limits = [
        barrier
        for barrier in layout.barriers
        if isinstance(barrier, CoordinateLimit) and barrier.is_of_position and barrier.index == index
    ]
    low = max((limit.bound for limit in limits if not limit.upper), default=None)
    high = min((limit.bound for limit in limits if limit.upper), default=None)
    return {"name": f"joint {index + 1}", "column": f"q_{index}", "low": low, "high": high}
