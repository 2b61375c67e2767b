"""Validation of message fields beyond their types: a table of rules and the check of a message.

In every message floats are finite, enum values are known and not UNSPECIFIED, and vectors have at most
``MAX_VECTOR`` numbers. ``RULES`` adds the rules of single fields. Sender and reader run the same check.
"""

from collections.abc import Callable, Mapping
from enum import IntEnum
from math import inf, isfinite, nextafter
from typing import Any, Final, NamedTuple

from passafe_protocol.errors import InvalidMessageError
from passafe_protocol.link_effect import CAUSES, EFFECTS
from passafe_protocol.link_settings import DISTRIBUTIONS, MAX_DELAY_S, MAX_QUEUE, MAX_SCHEDULE_S, RANGES
from passafe_protocol.messages import (
    UNSEQUENCED,
    BarrierReport,
    Certificate,
    CommandState,
    Consumed,
    EmergencyStop,
    Event,
    EventKind,
    FilterTick,
    GuardAction,
    Header,
    Health,
    LinkConfig,
    LinkEvent,
    LinkOutage,
    LinkParameters,
    LinkSource,
    LinkState,
    OperatorCommand,
    OperatorLease,
    OverrideReport,
    PlantInput,
    PlantState,
    Receipt,
    Record,
    RecordedSession,
    RowReport,
    ScenarioInfo,
    Steer,
    StopClear,
    TopicHealth,
    WhoDrives,
)
from passafe_protocol.networks import NETWORKS
from passafe_protocol.shapes import RecordType, Shape
from passafe_protocol.topics import LINKS

MAX_VECTOR: Final = 64
"""Most numbers in a vector."""

UNKNOWN_AGE_NS: Final = -1
"""Age of a message that was never received."""


class Rule(NamedTuple):
    """Rule for one field.

    Attributes:
        field: Its name.
        allowed: The rule in words.
        holds: Checks it on the whole message.
        least: Smallest number allowed, if the rule bounds a number or those of a vector.
        largest: Largest number allowed.
    """

    field: str
    allowed: str
    holds: Callable[[Any], bool]
    least: float | None = None
    largest: float = inf


def _text(field: str) -> Rule:
    return Rule(field, "text, not empty", lambda m: getattr(m, field) != "")


def _one_of(field: str, *choices: str) -> Rule:
    return Rule(field, ", ".join(choices), lambda m: getattr(m, field) in choices)


def _not_negative(field: str) -> Rule:
    return Rule(field, "≥ 0", lambda m: getattr(m, field) >= 0, 0)


def _positive(field: str) -> Rule:
    return Rule(field, "> 0", lambda m: getattr(m, field) > 0, nextafter(0.0, 1.0))


def _between(field: str, least: float, largest: float) -> Rule:
    allowed = f"{least:g} to {largest:g}"
    return Rule(field, allowed, lambda m: least <= getattr(m, field) <= largest, least, largest)


def _age(field: str) -> Rule:
    allowed = "≥ 0, or −1 before the first one"
    return Rule(field, allowed, lambda m: getattr(m, field) >= UNKNOWN_AGE_NS, UNKNOWN_AGE_NS)


def _plant_time(field: str) -> Rule:
    return Rule(field, "≥ 0, or −1 for none", lambda m: getattr(m, field) >= UNSEQUENCED, UNSEQUENCED)


def _numbers(field: str, least: float, largest: float = inf) -> Rule:
    allowed = f"numbers ≥ {least:g}" if largest == inf else f"numbers from {least:g} to {largest:g}"
    return Rule(field, allowed, lambda m: all(least <= x <= largest for x in getattr(m, field)), least, largest)


def _vector(field: str) -> Rule:
    return Rule(field, f"1 to {MAX_VECTOR} numbers", lambda m: len(getattr(m, field)) > 0)


def _empty_or_as_long_as(field: str, other: str) -> Rule:
    allowed = f"no numbers, or as many as {other}"
    return Rule(field, allowed, lambda m: len(getattr(m, field)) in {0, len(getattr(m, other))})


RULES: Final[dict[RecordType, tuple[Rule, ...]]] = {
    Header: (_text("source"),),
    OperatorCommand: (
        _vector("u_h"),
        _empty_or_as_long_as("u_h_rate", "u_h"),
        _text("device"),
        _not_negative("echoed_for_ns"),
    ),
    Steer: (
        _positive("turn"),
        _one_of("driver", *WhoDrives),
        _numbers("shares", -1.0, 1.0),
        Rule("page", "> 0 for a page that drives, else 0", lambda m: (m.page > 0) == (m.driver == WhoDrives.PAGE)),
        _not_negative("age_ns"),
        _not_negative("echoed_for_ns"),
    ),
    EmergencyStop: (_positive("id"), _text("reason")),
    StopClear: (_positive("stop"), _text("reason")),
    OperatorLease: (_age("command_age_ns"),),
    PlantInput: (
        _vector("u"),
        _plant_time("input_sequence_start_ns"),
        _plant_time("known_break_ns"),
        Rule("previous_u", "as many numbers as u, or a multiple", lambda m: len(m.previous_u) % len(m.u) == 0),
    ),
    PlantState: (
        _vector("x"),
        _vector("y"),
        _vector("u"),
        _not_negative("integration_error"),
        _plant_time("sequence_break_ns"),
        Rule("guard", f"{', '.join(filter(None, GuardAction))}, or empty", lambda m: m.guard in {*GuardAction}),
        _empty_or_as_long_as("u_asked", "u"),
        _empty_or_as_long_as("true_x", "x"),
    ),
    BarrierReport: (_text("name"), _vector("psi")),
    RowReport: (_text("name"), _not_negative("relaxed")),
    OverrideReport: (_between("allowed_fraction", 0, 1.0),),
    Certificate: (_not_negative("dual_residual"), _not_negative("gap")),
    Consumed: (_text("topic"),),
    FilterTick: (
        _one_of("mode", "off", "safe", "passive", "both"),
        _one_of("law", "sampled", "continuous"),
        _vector("u"),
        *(_empty_or_as_long_as(field, "u") for field in ("u_h", "u_h_rate", "u_nominal", "phi", "v")),
        _age("state_age_ns"),
        _age("command_age_ns"),
        Rule("command_state", f"{', '.join(CommandState)}, or empty", lambda m: m.command_state in {"", *CommandState}),
        _between("command_share", 0, 1.0),
        Rule(
            "override",
            "a held_back of no numbers, or as many as u",
            lambda m: len(m.override.held_back) in {0, len(m.u)},
        ),
        _empty_or_as_long_as("x_error", "x_hat"),
        _numbers("x_error", 0.0),
        _empty_or_as_long_as("residual", "x_hat"),
        _numbers("residual", 0.0),
    ),
    LinkOutage: (_between("start_s", 0, MAX_SCHEDULE_S), _between("end_s", 0, MAX_SCHEDULE_S)),
    LinkParameters: (
        *(_between(field, least, largest) for field, (least, largest) in RANGES.items()),
        _one_of("distribution", *DISTRIBUTIONS),
        Rule("network", f"{', '.join(NETWORKS)}, or empty", lambda m: m.network in {"", *NETWORKS}),
        _numbers("quantiles_s", 0.0, MAX_DELAY_S),
        _between("queue", 1, MAX_QUEUE),
    ),
    LinkConfig: (_one_of("link", *LINKS),),
    LinkEvent: (
        _one_of("link", *LINKS),
        _one_of("effect", *EFFECTS),
        _text("topic"),
        Rule("cause", f"{', '.join(CAUSES)}, or empty", lambda m: m.cause in {"", *CAUSES}),
    ),
    LinkSource: (_text("source"),),
    LinkState: (
        _one_of("link", *LINKS),
        _text("topic"),
        _one_of("trigger", "start", "period", "scheduled", "requested", "end"),
    ),
    TopicHealth: (_text("topic"),),
    Health: (_not_negative("rate_hz"), _not_negative("late_us_max")),
    RecordedSession: (_text("source"), _text("topic")),
    Receipt: (),
    Event: (
        _one_of("severity", "info", "warning", "error"),
        _text("text"),
        Rule("kind", f"{', '.join(filter(None, EventKind))}, or empty", lambda m: m.kind in {*EventKind}),
        _not_negative("factor"),
    ),
    ScenarioInfo: (_text("scenario_json"), _one_of("driver", "live", "lockstep"), _text("versions_json")),
}


def check(topic: str, shape: Shape, record: Record, path: str = "") -> None:
    """Check the fields of a message.

    Args:
        topic: Name of the topic, for the error.
        shape: Shape of ``record``.
        record: The message, or a record within it, with fields of the right types.
        path: Path of ``record`` in the message: empty, or such as ``rows[1].``.

    Raises:
        InvalidMessageError: A field has a value that is not allowed; the first one is named.
    """
    value = shape.read(record)
    _check_numbers(topic, shape, value, path)
    for index, name, members in shape.enums:
        member_of(topic, path + name, value[index], members)
    for rule in RULES[shape.record_type]:
        if not rule.holds(record):
            raise InvalidMessageError(topic, path + rule.field, getattr(record, rule.field), rule.allowed)
    for index, name, part in shape.parts:
        check(topic, part, value[index], f"{path}{name}.")
    for index, name, part in shape.lists:
        for k, element in enumerate(value[index]):
            check(topic, part, element, f"{path}{name}[{k}].")


def member_of(topic: str, field: str, value: int, members: Mapping[int, IntEnum]) -> IntEnum:
    """Return the member of an enumeration by its value.

    Args:
        topic: Name of the topic, for the error.
        field: Path of the value in the message.
        value: The value.
        members: Members by value.

    Raises:
        InvalidMessageError: No member has this value.
    """
    if value not in members:
        allowed = ", ".join(f"{member.value} ({member.name})" for member in members.values())
        raise InvalidMessageError(topic, field, value, allowed)
    return members[value]


def _check_numbers(topic: str, shape: Shape, value: tuple[Any, ...], path: str) -> None:
    total = 0.0
    for index, name in shape.vectors:
        vector = value[index]
        if len(vector) > MAX_VECTOR:
            raise InvalidMessageError(topic, path + name, vector, f"at most {MAX_VECTOR} numbers")
        total += sum(vector)
    for index, _ in shape.floats:
        total += value[index]
    # One test for all numbers: a NaN or inf makes their sum NaN or inf. So may an overflow of finite numbers, which
    # the search accepts.
    if not isfinite(total):
        _find_not_finite(topic, shape, value, path)


def _find_not_finite(topic: str, shape: Shape, value: tuple[Any, ...], path: str) -> None:
    for index, name in shape.vectors:
        if not all(map(isfinite, value[index])):
            raise InvalidMessageError(topic, path + name, value[index], "finite numbers")
    for index, name in shape.floats:
        if not isfinite(value[index]):
            raise InvalidMessageError(topic, path + name, value[index], "a finite number")
