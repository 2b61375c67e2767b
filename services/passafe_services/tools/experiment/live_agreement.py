"""The agreement of a live run with lockstep: every metric of a review, its difference, and what difference is allowed.

A live run is late here and there, and where links are random it is another draw of them: which message meets which
fate depends on how many went before. So the same run is made in lockstep with several seeds of the links, and the live
metric must lie within what these show, or no further outside than the tolerance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Final, NamedTuple

from passafe_protocol.messages import FilterStatus, FilterTick, Message, PlantInput

from passafe_services.scenarios.link_schema import ScenarioLink
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verdict_words import AGREEMENT, EVIDENCE

US_PER_MS: Final = 1e3

DRAWS: Final = 20
"""Seeds of the links in lockstep, where anything about them is random."""

FIRST_DRAW: Final = 1_000_000
"""The first of these seeds."""


class AllowedDifference(NamedTuple):
    """Largest distance at which a live metric may lie outside.

    Attributes:
        most: In the unit of the metric.
        reason: Why as much as that.
    """

    most: float
    reason: str


LATE: Final = "inputs up to 5 ms late are held so long"
"""Premise of every tolerance below, which ``lateness_ms`` checks: no step began later than that."""

TOLERANCES: Final[Mapping[str, AllowedDifference]] = {
    "duration_s": AllowedDifference(0.002, "the plant ends at the first step that reaches it"),
    "h_min": AllowedDifference(0.01, f"{LATE}: at 1 m/s, 5 mm, where h grows by 2 for each metre"),
    "h_min_at_samples": AllowedDifference(0.01, "as h_min"),
    "tank_min_j": AllowedDifference(0.05, f"{LATE}: 5 ms of 10 W"),
    "power_margin_min": AllowedDifference(
        1.0, f"{LATE}: u lags by 5 ms of up to 100 per s, times a speed of 1 m/s, doubled"
    ),
    "power_margin_min_at_samples": AllowedDifference(1.0, "as power_margin_min"),
    "u_norm_max": AllowedDifference(1.0, f"{LATE}: the next one makes up for 5 ms of up to 100 per s, doubled"),
    "final_x": AllowedDifference(0.02, f"{LATE}: 5 ms of 1 m/s or of 1 m/s², with as much again for the way back"),
    "ticks": AllowedDifference(0.01, "share: 1 % of the ticks may be skipped to catch up"),
    "command_age_ms_p50": AllowedDifference(
        1.5, "one more hop: a message waits for the next tick, of 1 ms, and half of one"
    ),
    "command_age_ms_p99": AllowedDifference(10.0, "operator or router may be late by as much"),
    "sequence_breaks": AllowedDifference(
        0.0,
        "links and play-out alone decide it; with more of them the machine was later than that, and all differs",
    ),
    "status_share": AllowedDifference(0.02, "share: a late message makes the filter predict from another state"),
}
"""By metric; those of ``status_share`` hold for the share of ticks of every status."""

MOST_LATE_MS: Final = 5.0
"""The premise of all of them."""


class Agreement(NamedTuple):
    """One metric, live and in lockstep.

    Attributes:
        cell: The run, in words.
        metric: Name.
        live: What the live run's log shows; ``None`` if nothing.
        low: Smallest that the runs in lockstep show.
        high: Largest.
        difference: How far outside the live one lies; 0 if it is within, infinite where only one has the metric.
        tolerance: How far it may.
        reason: Why so far.
    """

    cell: str
    metric: str
    live: float | None
    low: float | None
    high: float | None
    difference: float
    tolerance: float
    reason: str

    @property
    def agrees(self) -> bool:
        """True if it is no further."""
        return self.difference <= self.tolerance


def draws_of(scenario: Scenario) -> list[Scenario]:
    """Return the scenario with every seed of its links that it is to be run with in lockstep."""
    if not (scenario.link_changes or any(map(_is_random, scenario.links.values()))):
        return [scenario]
    return [
        scenario.model_copy(
            update={"links": {name: link.model_copy(update={"seed": seed}) for name, link in scenario.links.items()}}
        )
        for seed in range(FIRST_DRAW, FIRST_DRAW + DRAWS)
    ]


def compare(cell: str, live: Verdict, lockstep: Sequence[Metrics]) -> list[Agreement]:
    """Compare a live run with at least one in lockstep; every metric of ``TOLERANCES``, and every property.

    Args:
        cell: The run, in words.
        live: Of the live run's log.
        lockstep: Of the runs in lockstep.
    """
    seen, others = _metrics_of(live), [_metrics_of(one) for one in lockstep]
    names = list(dict.fromkeys([*seen, *(name for one in others for name in one)]))
    found = []
    for name in names:
        family = name.partition(":")[0]
        tolerance = TOLERANCES.get(family, AllowedDifference(0.0, "it holds or it does not"))
        found.append(_compared(cell, name, seen.get(name), [one.get(name) for one in others], tolerance))
    return [*found, _lateness(cell, live)]


def until(log: RunLog, duration_s: float) -> RunLog:
    """Return a log without ticks and inputs for plant times beyond a duration: their number is a matter of chance."""
    end_ns = round(duration_s * NS_PER_S)
    kept = {name: [one for one in found if not _is_for_later(one.body, end_ns)] for name, found in log.messages.items()}
    return replace(log, messages=kept)


def _is_for_later(body: Message, end_ns: int) -> bool:
    return isinstance(body, PlantInput | FilterTick) and body.effective_plant_ns > end_ns


def _lateness(cell: str, live: Verdict) -> Agreement:
    """Return by how much a step of the live run began after its time at most, which lockstep never does."""
    worst = [late.max / US_PER_MS for late in (live.timing.late_us or {}).values()]
    most = max(worst, default=None)
    reason = "the premise of all other tolerances"
    return Agreement(cell, "lateness_ms", most, 0.0, 0.0, 0.0 if most is None else most, MOST_LATE_MS, reason)


def _compared(
    cell: str, name: str, live: float | None, lockstep: Sequence[float | None], tolerance: AllowedDifference
) -> Agreement:
    known = [value for value in lockstep if value is not None]
    low, high = min(known, default=None), max(known, default=None)
    if live is None or low is None or high is None:
        difference = 0.0 if live is low is None else inf
    else:
        difference = max(low - live, live - high, 0.0)
        if name == "ticks":
            difference /= high
    return Agreement(cell, name, live, low, high, difference, tolerance.most, tolerance.reason)


def _metrics_of(one: Verdict | Metrics) -> dict[str, float | None]:
    """Return a run's metrics as numbers: lists one by one, statuses as shares, properties as 1, 0 or none."""
    listed = {"final_x", "status_share"}
    found: dict[str, float | None] = {name: getattr(one, name) for name in TOLERANCES if name not in listed}
    found |= {f"final_x:{k}": value for k, value in enumerate(one.final_x or ())}
    ticks = max(one.ticks, 1)
    found |= {f"status_share:{s.name}": one.status_counts.get(s.name, 0) / ticks for s in FilterStatus}
    found |= {
        f"holds:{name}": None if holds is None else float(holds)
        for name, holds in _holding(one).items()
        if name not in (*EVIDENCE, *AGREEMENT)  # of the log, not of the run
    }
    return found


def _holding(one: Verdict | Metrics) -> dict[str, bool | None]:
    if isinstance(one, Metrics):
        return one.properties
    return {name: entry.holds for name, entry in one.properties.items()}


def _is_random(link: ScenarioLink) -> bool:
    """Check whether a link has random effects, so that its seed matters."""
    return link != ScenarioLink(delay_s=link.delay_s, seed=link.seed)
