"""Properties that a run must have: safe, passive, bounded, certified, consistent and complete."""

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Final, NamedTuple

from passafe_protocol.messages import FilterStatus
from passafe_protocol.topics import COMMAND, INPUT, STATE, TICK
from pydantic import BaseModel, ConfigDict

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.fallback_record import FallbackRecord
from passafe_services.tools.review.filter_claims import Decisions, SentInputs
from passafe_services.tools.review.input_limits import InputLimitRecord
from passafe_services.tools.review.link_accounts import LinkAccount
from passafe_services.tools.review.property import Property, at_least, at_most
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory

CONTROL_TOPICS: Final = (COMMAND, INPUT, STATE, TICK)

ENFORCE_SAFETY: Final = ("safe", "both")
"""Modes that keep barriers."""

START_ROUNDING: Final = 1e-9
"""How far below 0 a value of the start may be: one on the boundary of the protected set counts as in it."""

END_PERIODS: Final = 2
"""Periods by which the last state of a whole run may come before its end."""


class Tolerances(BaseModel):
    """Tolerances of the recomputed values.

    They are the same for every scenario and mode, and are printed with the verdict.

    Attributes:
        h: Barrier value, in the unit of the barrier, beyond the errors of rounding and integration that are bounded for
            every value on its own.
        power_margin_w: Power margin, W.
        tank_j: Energy of the tank, J.
        input_relative: Bound of the input, relative.
        mismatch_relative: Distance between a logged state and the model's prediction, relative to 1 + ‖x‖∞.
        certificate: Each residual and the gap of a certificate, in their own relative units.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    h: float = 0.0
    power_margin_w: float = 0.05
    tank_j: float = 1e-9
    input_relative: float = 1e-9
    mismatch_relative: float = 1e-6
    certificate: float = 1e-6


def judge_driving(decisions: Decisions, states: Iterable[tuple[bool, int]], period_s: float) -> dict[str, Property]:
    """Return the properties that come first in a verdict: no tick in a fallback, and a robot that could be driven.

    Args:
        decisions: Decisions of the filter.
        states: Whether an input of the filter was in force, and plant time, ns, of each state of the moving plant.
        period_s: Period of a tick, s.
    """
    of_value = {status.value: status for status in FilterStatus}
    ticks = [(of_value[status], at_ns) for status, at_ns in zip(*_lists(decisions), strict=True)]
    return {
        "no-fallback": FallbackRecord.of(ticks, round(period_s * NS_PER_S)).property(),
        "driven": DriveRecord.of(ticks, states).property(),
    }


def _lists(decisions: Decisions) -> tuple[list[int], list[int]]:
    return decisions.status.tolist(), decisions.at_ns.tolist()


def judge_properties(
    scenario: Scenario,
    inputs: SentInputs,
    decisions: Decisions,
    trajectory: Trajectory,
    margins: RecomputedMargins,
    tolerances: Tolerances,
) -> dict[str, Property]:
    """Return every property of the run itself, not of its log, by name.

    Args:
        scenario: The scenario.
        inputs: Inputs that the filter sent.
        decisions: Decisions of the filter.
        trajectory: Motion of the plant.
        margins: Extrema of the run.
        tolerances: Tolerances of the recomputed values.
    """
    limits = InputLimitRecord(scenario, tolerances.input_relative)
    limits.take_applied(trajectory.u, trajectory.t_s)
    limits.take_sent(inputs, session=0)
    uncertified = decisions.uncertified(tolerances.certificate)
    count = int(uncertified.sum())
    first_s = float(decisions.at_ns[uncertified.argmax()] / NS_PER_S) if count else None
    certified = judge_certificates(
        uncertified.size, count, first_s, tolerances.certificate, required=scenario.filter.mode != "off"
    )
    return judge_run(scenario, margins, tolerances, bounded=limits.property(), certified=certified)


def judge_run(
    scenario: Scenario, margins: RecomputedMargins, tolerances: Tolerances, *, bounded: Property, certified: Property
) -> dict[str, Property]:
    """Return every property of the run itself, not of its log, by name.

    Args:
        scenario: The scenario.
        margins: Extrema of the run.
        tolerances: Tolerances of the recomputed values.
        bounded: The property that inputs were within their limits.
        certified: The property that solutions had certificates.
    """
    return judge_margins(margins, scenario, tolerances) | {
        "energy": _energy(margins, scenario, tolerances),
        "bounded": bounded,
        "certified": certified,
        "consistent": _consistent(margins, scenario, tolerances),
    }


def _consistent(margins: RecomputedMargins, scenario: Scenario, tolerances: Tolerances) -> Property:
    """Judge whether the plant moved as its model does; where it is not the model, nothing is judged."""
    judged = at_most(
        margins.mismatch_max,
        tolerances.mismatch_relative,
        required=scenario.is_exact,
        what="distance of each state from the model's prediction from the previous state, relative",
    )
    return judged if scenario.is_exact else judged.model_copy(update={"holds": None})


def judge_margins(margins: RecomputedMargins, scenario: Scenario, tolerances: Tolerances) -> dict[str, Property]:
    """Return the properties that the filter is there for, by name, and whether the start allowed to promise safety."""
    return {
        "safe": _safe(margins, scenario, tolerances),
        "protected-start": _protected_start(margins, scenario),
        "passive": _passive(margins, scenario, tolerances),
    }


class Completeness(NamedTuple):
    """Evidence of whether a log contains the whole run.

    Attributes:
        gaps: Messages that are missing between others, or before the first one of the filter.
        out_of_order: Messages that came too late in the log to be looked at.
        contradicting: Messages with the number of another one.
        first_gap_s: Plant time of the last state before the first gap, s.
        is_finished: Whether its writer finished the log.
        shows_start: Whether it starts before the plant's first input, or at most one period after it.
        cut_short: Reason for which it is not of a whole run, in words; empty without one.
        shortcomings: Reasons for which checkpoints do not prove that nothing is missing, in words.
    """

    gaps: int
    out_of_order: int
    contradicting: int
    first_gap_s: float | None
    is_finished: bool
    shows_start: bool
    cut_short: str
    shortcomings: Sequence[str]


def judge_completeness(found: Completeness) -> Property:
    """Return the property that the log contains the whole run."""
    missing = found.gaps + found.out_of_order + found.contradicting
    doubt = found.cut_short or "; ".join(found.shortcomings)
    late = f"{found.out_of_order} messages came too late in the log to be looked at" if found.out_of_order else ""
    other = f"{found.contradicting} messages have the number of another one" if found.contradicting else ""
    return Property(
        holds=missing == 0 and found.is_finished and found.shows_start and not doubt,
        required=True,
        worst=float(missing) if missing or not doubt else None,  # then it is not messages that are missing
        at_s=found.first_gap_s,
        requirement="messages missing between others, or before the first one of the filter = 0, to the end",
        allowed="= 0",
        note=", ".join(note for note in (doubt, late, other) if note),
    )


WITHIN_READING: Final = "the robot may have been outside of its limits by no more than the error of the states as read"
"""Note of a barrier value that is below 0, but not by more than what the scenario says of its sensors."""


def _safe(margins: RecomputedMargins, scenario: Scenario, tolerances: Tolerances) -> Property:
    """Judge the smallest value of any barrier; it may be below 0 by its own error, and by no more."""
    lowest, kept = margins.h_min, margins.h_kept
    error = 0.0 if lowest is None or kept is None or not isfinite(lowest.value) else kept.value - lowest.value
    judged = at_least(
        lowest,
        -tolerances.h - error,
        required=_asks_for_safety(scenario),
        what="smallest barrier value h(x), also between samples, but for rounding and integration,",
    )
    if not scenario.filter.barriers and scenario.filter.mode in ENFORCE_SAFETY:
        return judged.model_copy(update={"note": "there is no barrier, so nothing was looked at for safety"})
    if kept is not None:
        judged = judged.model_copy(update={"holds": kept.value >= -tolerances.h})
    possible = margins.h_possible
    if judged.holds is False and possible is not None and possible.value >= -tolerances.h:
        return judged.model_copy(update={"holds": None, "note": WITHIN_READING})
    return judged


def _asks_for_safety(scenario: Scenario) -> bool:
    return scenario.filter.mode in ENFORCE_SAFETY and bool(scenario.filter.barriers)


def _protected_start(margins: RecomputedMargins, scenario: Scenario) -> Property:
    """Judge whether the plant started in the set that the filter protects; if not, the verdict says so in words."""
    judged = at_least(
        margins.start_psi,
        -START_ROUNDING,
        required=False,
        what="smallest of ψ₀ … ψ_{r−1} of all barriers where the plant started",
    )
    if judged.holds is not False or not _asks_for_safety(scenario):
        return judged
    where = f"{margins.start_level} was {judged.worst:.3g}"
    return judged.model_copy(update={"note": f"the start was outside of the protected set: {where}"})


def _passive(margins: RecomputedMargins, scenario: Scenario, tolerances: Tolerances) -> Property:
    required = scenario.filter.mode in ("passive", "both")
    if scenario.filter.passivity.kind == "tank":
        what = "energy of the tank, J, also between samples,"
        return at_least(margins.tank_min_j, -tolerances.tank_j, required=required, what=what)
    return at_least(
        margins.power_margin_min,
        -tolerances.power_margin_w,
        required=required,
        what="power margin h_u(x, u), W, also between samples",
    )


def _energy(margins: RecomputedMargins, scenario: Scenario, tolerances: Tolerances) -> Property:
    """Judge E(t) ≥ E_r − ∫δ dt: whatever the tank lost below its reserve was granted, and reported, as slack."""
    asks = scenario.filter
    return at_least(
        margins.energy_kept_j,
        -tolerances.tank_j,
        required=asks.mode in ("passive", "both") and asks.law == "sampled" and asks.passivity.kind == "tank",
        what="energy of the tank above its reserve, with the slack that was granted since the start, J,",
    )


def judge_certificates(
    ticks: int, uncertified: int, first_s: float | None, limit: float, *, required: bool
) -> Property:
    """Return the property that every tick that claims a solution has a certificate within a limit.

    Args:
        ticks: Ticks of the run.
        uncertified: Those that claim a solution without such a certificate.
        first_s: Plant time of the first of them, s.
        limit: Largest residual and gap.
        required: Whether the mode asks for it.
    """
    return Property(
        holds=uncertified == 0 if ticks else None,
        required=required,
        worst=float(uncertified) if ticks else None,
        at_s=first_s,
        requirement=f"ticks that claim a solution without a certificate accepted within {limit:g} = 0",
        allowed="= 0",
    )


def judge_links(accounts: Sequence[LinkAccount], *, has_events: bool = False) -> Property:
    """Return the property that every message of every link is accounted for; required if the log has links.

    Args:
        accounts: Account of each link; empty for logs without link states.
        has_events: Whether links report what they did to messages.
    """
    worst = max((max(account.differences.values(), default=0) for account in accounts), default=None)
    return Property(
        holds=None if worst is None else worst == 0,
        required=bool(accounts) or has_events,
        worst=None if worst is None else float(worst),
        at_s=None,
        requirement="differences between the states, the events and the logged messages of a link = 0",
        allowed="= 0",
    )


def cut_short(planned_s: float | None, lasted_s: float, period_s: float) -> str:
    """Return in words that the run ended before its time; empty if it did not, or was to last until it was stopped."""
    if planned_s is None or lasted_s >= planned_s - END_PERIODS * period_s:
        return ""
    return f"not a whole run: it ended after {lasted_s:.3f} s of {planned_s:g} s"
