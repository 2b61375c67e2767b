"""Words that a driver understands for what holds the robot now, most urgent first."""

from collections.abc import Callable, Mapping, Sequence
from math import hypot
from typing import Final, NamedTuple

from passafe_protocol.messages import CommandState, FilterStatus, FilterTick, GuardAction, PlantPhase
from passafe_services.filter.member_rows import without_member
from passafe_services.tools.review.verdict_so_far import TOLERANCES

from passafe_dashboard.live.barrier_gaps import Gap
from passafe_dashboard.live.command_words import command_words
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.gap_text import age_text, barrier_words, distance_text, is_at_limit
from passafe_dashboard.palette import STATUS_STYLES

LEAST_HELD: Final = 0.02
"""Share of the command below which a change of it is not worth a word."""

LEAST_ASKED: Final = 1e-3
"""Command below which the operator asks for nothing, units of u."""

LEAST_SHARE: Final = 0.1
"""Share of a row in the change below which it is not named."""


_COMMANDS: Final[Mapping[str, str]] = {
    CommandState.NONE: "No command of the operator has come yet.",
    CommandState.RELEASED: "The stick is let go: nothing is asked of the robot.",
    CommandState.SILENT: "No newer command of the operator comes.",
    CommandState.DELAYED: "The operator's commands are too old when they arrive.",
    CommandState.STOPPED: "Commands from before the stop was cleared do not count: let go once.",
}
"""Sentences for commands that do not count."""


class DriverWords(NamedTuple):
    """One sentence for the driver and a second one that explains it.

    Attributes:
        tone: ``free``, ``held``, ``guard`` (a fallback drives), ``broken`` (a limit or the system) or ``stopped``.
        headline: What is so.
        detail: Why, or what to do.
    """

    tone: str
    headline: str
    detail: str


class Situation(NamedTuple):
    """Situation that the words describe.

    Attributes:
        feed: State of the page.
        liveness: Whether messages arrive, as on the page.
        gaps: Distances to every barrier at the shown state.
        h: h of every barrier there.
    """

    feed: Feed
    liveness: Mapping[str, str]
    gaps: Sequence[Gap]
    h: Sequence[float]


def driver_words(situation: Situation) -> DriverWords:
    """Return the words for a situation: of the first rule that speaks."""
    for rule in _RULES:
        words = rule(situation)
        if words is not None:
            return words
    return _free(situation)


def _stopped(now: Situation) -> DriverWords | None:
    state = now.feed.run.state
    if state is None or not state.stop:
        return None
    return DriverWords(
        "stopped", "Emergency stop", f"Pressed at {state.stop_source}. The robot brakes by itself until it is cleared."
    )


def _not_live(now: Situation) -> DriverWords | None:
    headline = {"waiting": "Waiting for the robot", "silent": "Nothing new arrives", "ended": "The run is over"}
    kind = now.liveness["state"]
    return None if kind == "live" else DriverWords("broken", headline[kind], now.liveness["text"])


def _beyond_a_limit(now: Situation) -> DriverWords | None:
    beyond = [gap for gap, h in zip(now.gaps, now.h, strict=False) if h < -TOLERANCES.h]
    if not beyond:
        return None
    worst = min(beyond, key=lambda gap: gap.distance)
    headline = f"Beyond {_named(now, worst)} by {distance_text(worst.distance, worst.unit)}"
    off = now.feed.run.tick is not None and now.feed.run.tick.mode in ("off", "passive")
    return DriverWords("broken", headline, "The mode asks for no safety." if off else "A barrier does not hold.")


def _fail_safe(now: Situation) -> DriverWords | None:
    state, tick = now.feed.run.state, now.feed.run.tick
    if state is None or state.phase is not PlantPhase.FAIL_SAFE:
        return None
    stale = tick is not None and tick.status is FilterStatus.STALE
    detail = f"The filter waits. {_stale_reason(tick)}" if tick is not None and stale else "No input arrives in time."
    return DriverWords("guard", "The robot brakes by itself", detail)


def _guarded(now: Situation) -> DriverWords | None:
    """Return the words for a guard that acts: it has the last word, whatever the filter decided."""
    state = now.feed.run.state
    if state is None or state.guard not in {GuardAction.CHANGED, GuardAction.FAIL_SAFE}:
        return None
    why = "It judges every input on the robot's own state."
    if state.guard == GuardAction.FAIL_SAFE:
        return DriverWords("guard", "The guard at the robot brakes", f"No input keeps every limit for sure. {why}")
    gaps = {gap.name: gap for gap in now.gaps}
    name = without_member(state.guard_cause)
    cause = _with_distance(now, gaps[name]) if name in gaps else _row_words(name)
    return DriverWords("held", f"The guard at the robot holds back: {cause}", why)


def _stale(now: Situation) -> DriverWords | None:
    tick = now.feed.run.tick
    if tick is None or tick.status is not FilterStatus.STALE:
        return None
    return DriverWords("guard", "Standing by", _stale_reason(tick))


def _stale_reason(tick: FilterTick) -> str:
    if tick.command_state in (CommandState.COUNTS, CommandState.RESUMES):
        return f"The robot's newest state is {age_text(tick.state_age_ns)} old, too old to decide on."
    return _COMMANDS.get(tick.command_state, f"The operator's command {command_words(tick)}.")


def _fallback(now: Situation) -> DriverWords | None:
    tick = now.feed.run.tick
    headlines = {
        FilterStatus.INFEASIBLE: "Limits conflict: least of all evils",
        FilterStatus.UNCERTIFIED: "Braking: no certified answer",
        FilterStatus.AT_SAMPLES: "Braking to be sure between samples",
    }
    if tick is None or tick.status not in headlines:
        return None
    nearest = min(now.gaps, key=lambda gap: gap.distance, default=None)
    near = "" if nearest is None else f" Nearest: {_with_distance(now, nearest)}."
    return DriverWords("guard", headlines[tick.status], f"{STATUS_STYLES[tick.status].meaning.capitalize()}.{near}")


def _held(now: Situation) -> DriverWords | None:
    tick = now.feed.run.tick
    if tick is None or not tick.override.held_back:
        return None
    asked, held = hypot(*tick.u_h), hypot(*tick.override.held_back)
    if held <= max(LEAST_ASKED, LEAST_HELD * max(asked, hypot(*tick.u_nominal))):
        return None
    causes = _causes(now, tick)
    if not causes:
        return None
    if asked <= LEAST_ASKED:
        return DriverWords(
            "held", f"Kept off by {causes}", "Nothing of yours is held back: the robot's own controller is."
        )
    return DriverWords("held", f"Held back by {causes}", _passing(tick))


def _passing(tick: FilterTick) -> str:
    if tick.override.unavoidable:
        return "No part of the command would pass unchanged."
    # Rounded down, so that the share that is named does pass.
    return f"{int(100 * tick.override.allowed_fraction)} % of the command would pass unchanged."


def _causes(now: Situation, tick: FilterTick) -> str:
    gaps = {gap.name: gap for gap in now.gaps}
    rows = sorted((row for row in tick.rows if row.active), key=lambda row: -row.share)
    named: list[str] = []
    for row in rows:
        if named and row.share < LEAST_SHARE:
            continue
        name = without_member(row.name)
        words = _with_distance(now, gaps[name]) if name in gaps else _row_words(name)
        if words not in named:
            named.append(words)
    return " and ".join(named[:2])


def _row_words(name: str) -> str:
    return "the energy balance" if name == "passivity" else "the input limits"


def _with_distance(now: Situation, gap: Gap) -> str:
    if is_at_limit(gap.distance, gap.unit):
        return f"{_named(now, gap)}, {'touching it' if gap.unit == 'm' else 'at its limit'}"
    where = "away" if gap.unit in ("m", "rad") else "left"
    past = " beyond" if gap.distance < 0 else f" {where}"
    return f"{_named(now, gap)}, {distance_text(gap.distance, gap.unit)}{past}"


def _named(now: Situation, gap: Gap) -> str:
    kinds = {barrier.name: barrier.kind for barrier in now.feed.layout.barriers}
    return barrier_words(gap, kinds.get(gap.name, ""))


def _free(now: Situation) -> DriverWords:
    tick = now.feed.run.tick
    nearest = min(now.gaps, key=lambda gap: gap.distance, default=None)
    near = "" if nearest is None else f"Nearest: {_with_distance(now, nearest)}."
    if tick is None:
        return DriverWords("broken", "Waiting for the filter", near)
    if tick.command_state not in (CommandState.COUNTS, CommandState.RESUMES) and tick.command_state:
        return DriverWords("free", "Nobody steers", f"{_stale_reason(tick)} {near}".strip())
    if tick.status is FilterStatus.RELAXED:
        return DriverWords("held", f"Passivity gives way by {tick.slack:.2g} W", near)
    if tick.mode == "off":
        return DriverWords("held", "The filter is off", f"Nothing is held back. {near}".strip())
    is_free = nearest is None or not is_at_limit(nearest.distance, nearest.unit)
    return DriverWords("free", "The way is free" if is_free else "Nothing is held back", near)


_RULES: Final[tuple[Callable[[Situation], DriverWords | None], ...]] = (
    _stopped,
    _not_live,
    _beyond_a_limit,
    _fail_safe,
    _guarded,
    _stale,
    _fallback,
    _held,
)
