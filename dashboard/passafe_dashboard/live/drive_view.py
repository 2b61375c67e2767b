"""Make what the drive sheet shows of the feed: words, distances to barriers, directions held back, energy.

Distances are those of the plant's newest state; directions that are held back are those of the state that the filter
decided for.
"""

from collections.abc import Mapping, Sequence
from math import hypot
from typing import Any, TypeAlias

from passafe_protocol.messages import FilterTick
from passafe_services.scenarios.drawn_places import DrawnPlaces

from passafe_dashboard.columns import measured_h
from passafe_dashboard.live.barrier_gaps import LEAST_PULL, Gap
from passafe_dashboard.live.driver_words import Situation, driver_words
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.gap_text import distance_text

Json: TypeAlias = dict[str, Any]


def drive_view(feed: Feed, liveness: Mapping[str, str]) -> Json:
    """Return ``words``, ``gaps``, ``held`` and ``energy`` of the page's state.

    Args:
        feed: State of the page.
        liveness: Whether messages arrive.
    """
    state, tick = feed.run.state, feed.run.tick
    gaps = [] if state is None else feed.gaps(state.x, state.plant_ns)
    h = [] if state is None else feed.measured_h(state) or []
    return {
        "words": driver_words(Situation(feed, liveness, gaps, h))._asdict(),
        "gaps": _gaps(feed, gaps, h),
        "held": [] if tick is None else _held_directions(feed, tick),
        "energy": None if tick is None else _energy(feed, tick),
    }


def _gaps(feed: Feed, gaps: Sequence[Gap], h: Sequence[float]) -> list[Json]:
    worst = feed.run.worst
    nearest = min(gaps, key=lambda gap: gap.distance, default=None)
    return [
        {
            "name": gap.name,
            "distance": gap.distance,
            "unit": gap.unit,
            "text": f"{'−' if value < 0 else ''}{distance_text(gap.distance, gap.unit)}",
            "h": value,
            "lowest_h": worst[column].value if (column := measured_h(i)) in worst else None,
            "nearest": gap is nearest,
        }
        for i, (gap, value) in enumerate(zip(gaps, h, strict=False))
    ]


def _held_directions(feed: Feed, tick: FilterTick) -> list[Json]:
    """Return, by barrier and point, the direction towards it and how far the decision may go that way, units of u."""
    margins, drawn = {row.name: row.margin for row in tick.rows}, feed.layout.drawn
    return [
        {
            "name": gap.name,
            "point": point,
            "towards": (pull[0] / size, pull[1] / size),
            "margin": margins[gap.name] / size * _reach(drawn, tick, point, pull),  # while the others do as decided
        }
        for gap in feed.gaps(tick.x_hat, tick.effective_plant_ns)
        for point, pull in enumerate(gap.pulls)
        if gap.name in margins and (size := hypot(*pull)) > LEAST_PULL
    ]


def _reach(drawn: DrawnPlaces | None, tick: FilterTick, point: int, pull: tuple[float, float]) -> float:
    """Return how much input a unit of a point's acceleration takes; 1 where the input is that acceleration."""
    if drawn is None:
        return 1.0
    size = hypot(*pull)
    return drawn.reach(tick.x_hat, point, (pull[0] / size, pull[1] / size))


def _energy(feed: Feed, tick: FilterTick) -> Json | None:
    """Return the tank, or the power margin where the passivity row has none; ``None`` where nothing is asked for."""
    if feed.scenario is None:
        return None
    passivity = feed.scenario.filter.passivity
    asked = tick.mode in ("passive", "both")
    if passivity.kind == "tank":
        return {
            "kind": "tank",
            "asked": asked,
            "level_j": tick.tank_j,
            "reserve_j": passivity.tank_reserve_j,
            "max_j": passivity.tank_max_j,
        }
    return {"kind": "power", "asked": asked, "margin_w": tick.power_margin}
