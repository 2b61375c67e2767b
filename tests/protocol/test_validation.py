"""Every rule has cases that it refuses and cases at its edge that it allows."""

from collections.abc import Callable
from math import inf, nan
from typing import Any, TypeAlias

import pytest
from link_parameters import PARAMETERS
from msgspec.structs import replace
from passafe_protocol.errors import InvalidMessageError
from passafe_protocol.link_effect import CAUSES, EFFECTS
from passafe_protocol.link_settings import DISTRIBUTIONS, RANGES
from passafe_protocol.messages import (
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
    LinkSource,
    LinkState,
    Message,
    OperatorCommand,
    OperatorLease,
    OverrideReport,
    PlantInput,
    PlantState,
    Receipt,
    RecordedSession,
    RowReport,
    ScenarioInfo,
    Steer,
    StopClear,
    TopicHealth,
)
from passafe_protocol.networks import NETWORKS
from passafe_protocol.shapes import Shape, shape_of
from passafe_protocol.topics import TOPICS
from passafe_protocol.validation import MAX_VECTOR, RULES, check

CERTIFICATE = Certificate("piqp", accepted=True, primal_residual=0.0, dual_residual=0.0, gap=0.0)
LONG = (0.0,) * (MAX_VECTOR + 1)

# Fields of a link's parameters and the field that is to be named.
BAD_PARAMETERS: list[tuple[dict[str, Any], str]] = [
    *(({field: least - 1e-9}, field) for field, (least, _) in RANGES.items()),
    *(({field: largest * 1.001}, field) for field, (_, largest) in RANGES.items()),
    ({"distribution": "gamma"}, "distribution"),
    ({"network": "moon"}, "network"),
    ({"quantiles_s": (0.0, 10.001)}, "quantiles_s"),
    ({"queue": 0}, "queue"),
    ({"queue": 1_000_001}, "queue"),
    ({"outages": (LinkOutage(-1e-9, 1.0),)}, "outages[0].start_s"),
    ({"outages": (LinkOutage(0.0, 1.001e6),)}, "outages[0].end_s"),
]

UNWATCHED: dict[str, Any] = {"x_error": (), "residual": ()}

# Message type, fields to replace in a valid message, and the field that is to be named.
REFUSED: list[tuple[type, dict[str, Any], str]] = [
    (Header, {"source": ""}, "source"),
    (OperatorCommand, {"u_h": (), "u_h_rate": ()}, "u_h"),
    (OperatorCommand, {"u_h": LONG, "u_h_rate": ()}, "u_h"),
    (OperatorCommand, {"u_h_rate": (0.0,)}, "u_h_rate"),
    (OperatorCommand, {"u_h_rate": (0.0,) * 3}, "u_h_rate"),
    (OperatorCommand, {"device": ""}, "device"),
    (PlantInput, {"u": ()}, "u"),
    (PlantInput, {"u": LONG}, "u"),
    (PlantInput, {"input_sequence_start_ns": -2}, "input_sequence_start_ns"),
    (PlantInput, {"known_break_ns": -2}, "known_break_ns"),
    (PlantInput, {"previous_u": (0.0,)}, "previous_u"),
    (PlantInput, {"previous_u": (0.0,) * 3}, "previous_u"),
    (PlantInput, {"previous_u": (*LONG[1:], 0.0, 0.0)}, "previous_u"),
    (PlantState, {"sequence_break_ns": -2}, "sequence_break_ns"),
    (PlantState, {"x": ()}, "x"),
    (PlantState, {"x": LONG}, "x"),
    (PlantState, {"y": ()}, "y"),
    (PlantState, {"u": ()}, "u"),
    (PlantState, {"phase": 0}, "phase"),
    (PlantState, {"phase": 5}, "phase"),
    (PlantState, {"integration_error": -1e-300}, "integration_error"),
    (PlantState, {"guard": "asleep"}, "guard"),
    (PlantState, {"u_asked": (0.0,)}, "u_asked"),
    (PlantState, {"true_x": (0.0,)}, "true_x"),
    (FilterTick, {"status": 0}, "status"),
    (FilterTick, {"status": 10}, "status"),
    (FilterTick, {"mode": "on"}, "mode"),
    (FilterTick, {"law": ""}, "law"),
    (FilterTick, {"x_hat": LONG}, "x_hat"),
    (FilterTick, {"u": ()}, "u"),
    (FilterTick, {"u_h": (0.0,)}, "u_h"),
    (FilterTick, {"override": OverrideReport(held_back=(0.0,))}, "override"),
    (FilterTick, {"override": OverrideReport(allowed_fraction=-1e-9)}, "override.allowed_fraction"),
    (FilterTick, {"override": OverrideReport(allowed_fraction=1.0000001)}, "override.allowed_fraction"),
    (FilterTick, {"rows": (RowReport("r", 0.0, 0.0, active=False, relaxed=-1e-300),)}, "rows[0].relaxed"),
    (FilterTick, {"u_h_rate": (0.0,)}, "u_h_rate"),
    (FilterTick, {"u_nominal": (0.0,)}, "u_nominal"),
    (FilterTick, {"phi": (0.0,)}, "phi"),
    (FilterTick, {"v": (0.0,) * 3}, "v"),
    (FilterTick, {"barriers": (BarrierReport("a", (1.0,)), BarrierReport("", (1.0,)))}, "barriers[1].name"),
    (FilterTick, {"barriers": (BarrierReport("disk", ()),)}, "barriers[0].psi"),
    (FilterTick, {"barriers": (BarrierReport("disk", LONG),)}, "barriers[0].psi"),
    (FilterTick, {"rows": (RowReport("", 0.0, 0.0, active=True),)}, "rows[0].name"),
    (FilterTick, {"certificate": replace(CERTIFICATE, dual_residual=-1e-9)}, "certificate.dual_residual"),
    (FilterTick, {"certificate": replace(CERTIFICATE, gap=-1e-9)}, "certificate.gap"),
    (FilterTick, {"consumed": (Consumed("", 0, 0, 0),)}, "consumed[0].topic"),
    (FilterTick, {"state_age_ns": -2}, "state_age_ns"),
    (FilterTick, {"command_age_ns": -2}, "command_age_ns"),
    (OperatorCommand, {"echoed_for_ns": -1}, "echoed_for_ns"),
    (Steer, {"turn": 0}, "turn"),
    (Steer, {"driver": "dog"}, "driver"),
    (Steer, {"shares": (0.0, 1.0000001)}, "shares"),
    (Steer, {"shares": (-1.0000001, 0.0)}, "shares"),
    (Steer, {"page": 0}, "page"),
    (Steer, {"driver": "nobody"}, "page"),
    (Steer, {"age_ns": -1}, "age_ns"),
    (Steer, {"echoed_for_ns": -1}, "echoed_for_ns"),
    (EmergencyStop, {"id": 0}, "id"),
    (EmergencyStop, {"reason": ""}, "reason"),
    (StopClear, {"stop": 0}, "stop"),
    (StopClear, {"reason": ""}, "reason"),
    (OperatorLease, {"command_age_ns": -2}, "command_age_ns"),
    (FilterTick, {"command_state": "asleep"}, "command_state"),
    (FilterTick, {"command_share": 1.0000001}, "command_share"),
    (FilterTick, {"command_share": -1e-9}, "command_share"),
    (FilterTick, {"x_error": (0.0,)}, "x_error"),
    (FilterTick, {"x_hat": (1.0,), "residual": (), "x_error": (-1e-9,)}, "x_error"),
    (FilterTick, {"residual": (0.0,)}, "residual"),
    (FilterTick, {"x_hat": (1.0,), "x_error": (), "residual": (-1e-9,)}, "residual"),
    (LinkConfig, {"link": "plant-to-recorder"}, "link"),
    *((LinkConfig, {"parameters": replace(PARAMETERS, **bad)}, f"parameters.{field}") for bad, field in BAD_PARAMETERS),
    (LinkState, {"link": ""}, "link"),
    (LinkState, {"topic": ""}, "topic"),
    (LinkState, {"trigger": "never"}, "trigger"),
    (LinkState, {"sources": (LinkSource("", 0, 0, 0, 0),)}, "sources[0].source"),
    *((LinkState, {"parameters": replace(PARAMETERS, **bad)}, f"parameters.{field}") for bad, field in BAD_PARAMETERS),
    (LinkEvent, {"link": ""}, "link"),
    (LinkEvent, {"effect": "eaten"}, "effect"),
    (LinkEvent, {"cause": "hunger"}, "cause"),
    (LinkEvent, {"topic": ""}, "topic"),
    (Health, {"rate_hz": -1e-9}, "rate_hz"),
    (Health, {"late_us_max": -1e-9}, "late_us_max"),
    (Health, {"topics": (TopicHealth("", 0, 0, 0),)}, "topics[0].topic"),
    (Receipt, {"sessions": (RecordedSession("", "state", 0, 0),)}, "sessions[0].source"),
    (Receipt, {"sessions": (RecordedSession("plant", "", 0, 0),)}, "sessions[0].topic"),
    (Event, {"severity": "fatal"}, "severity"),
    (Event, {"text": ""}, "text"),
    (Event, {"kind": "DOOM"}, "kind"),
    (Event, {"factor": -1e-9}, "factor"),
    (ScenarioInfo, {"scenario_json": ""}, "scenario_json"),
    (ScenarioInfo, {"driver": "dead"}, "driver"),
    (ScenarioInfo, {"versions_json": ""}, "versions_json"),
]

ALLOWED: list[tuple[type, dict[str, Any]]] = [
    (OperatorCommand, {"u_h": LONG[1:], "u_h_rate": LONG[1:]}),
    (OperatorCommand, {"u_h_rate": ()}),
    (PlantInput, {"u": (0.0,), "hold_ns": 0}),
    (Steer, {"driver": "nobody", "page": 0, "shares": ()}),
    (Steer, {"driver": "script", "page": 0, "age_ns": 0}),
    (EmergencyStop, {"id": 1}),
    (OperatorLease, {"number": 0, "holder": 0, "device": "", "command_age_ns": -1, "refused": 0}),
    (PlantState, {"stop": 0, "stop_source": "", "stops_cleared": 0}),
    (PlantInput, {"input_sequence_start_ns": -1, "known_break_ns": -1, "previous_u": ()}),
    (PlantInput, {"input_sequence_start_ns": 0, "known_break_ns": 0, "previous_u": LONG[1:]}),
    (PlantState, {"sequence_break_ns": -1, "input_since_ns": -5, "input_transit_ns": -5, "input_epoch": 0}),
    (PlantState, {"x": LONG[1:], "true_x": (), "integration_error": 0.0}),
    (PlantState, {"x": (1.7e308, 1.7e308), "true_x": (), "energy_in_j": 1.7e308}),  # finite, though their sum is not
    (PlantState, {"x": (-0.0, 5e-324), "true_x": ()}),
    *((PlantState, {"guard": action}) for action in GuardAction),
    (PlantState, {"u_asked": (), "true_x": ()}),
    *((Event, {"kind": kind}) for kind in EventKind),
    (FilterTick, {"x_hat": (), "u_h": (), "u_h_rate": (), "u_nominal": (), "phi": (), "v": (), **UNWATCHED}),
    (FilterTick, {"x_hat": (1.0,), "x_error": (0.0,), "residual": (0.0,)}),
    (FilterTick, {"barriers": (), "rows": (), "consumed": (), "state_age_ns": -1, "command_age_ns": -1}),
    *((FilterTick, {"command_state": state}) for state in ("", *CommandState)),
    (FilterTick, {"certificate": replace(CERTIFICATE, solver="", primal_residual=-1e-9)}),
    (FilterTick, {"rows": tuple(RowReport("r", 0.0, -1e-12, active=False) for _ in range(250))}),
    (FilterTick, {"override": OverrideReport()}),
    (FilterTick, {"override": OverrideReport((0.0, 0.0), allowed_fraction=1.0)}),
    *(
        (LinkConfig, {"parameters": replace(PARAMETERS, **{field: limit})})
        for field, limits in RANGES.items()
        for limit in limits
    ),
    (LinkConfig, {"parameters": replace(PARAMETERS, quantiles_s=(), outages=(), queue=1)}),
    *((LinkConfig, {"parameters": replace(PARAMETERS, distribution=each)}) for each in DISTRIBUTIONS),
    *((LinkConfig, {"parameters": replace(PARAMETERS, network=each)}) for each in NETWORKS),
    *((LinkEvent, {"effect": effect}) for effect in EFFECTS),
    *((LinkEvent, {"cause": cause}) for cause in ("", *CAUSES)),
    *((LinkState, {"trigger": each}) for each in ("start", "period", "scheduled", "requested", "end")),
    (Health, {"rate_hz": 0.0, "late_us_max": 0.0, "topics": ()}),
    *((Event, {"severity": severity}) for severity in ("info", "warning", "error")),
    *((FilterTick, {"mode": mode}) for mode in ("off", "safe", "passive", "both")),
    *((FilterTick, {"law": law}) for law in ("sampled", "continuous")),
    *((ScenarioInfo, {"driver": driver}) for driver in ("live", "lockstep")),
]

Replace: TypeAlias = Callable[[float], tuple]


def check_changed(valid: Message | Header, changes: dict[str, Any]) -> None:
    check("a topic", shape_of(type(valid)), replace(valid, **changes))


@pytest.mark.parametrize(("tuple_type", "changes", "field"), REFUSED)
def test_refused(
    header: Header,
    body_of: dict[type, Message],
    tuple_type: type,
    changes: dict[str, Any],
    field: str,
) -> None:
    with pytest.raises(InvalidMessageError) as caught:
        check_changed({Header: header, **body_of}[tuple_type], changes)

    assert (caught.value.topic, caught.value.field) == ("a topic", field)
    assert caught.value.allowed


@pytest.mark.parametrize(("tuple_type", "changes"), ALLOWED)
def test_allowed(body_of: dict[type, Message], tuple_type: type, changes: dict[str, Any]) -> None:
    check_changed(body_of[tuple_type], changes)


def test_every_rule_is_tested() -> None:
    def rules_under(shape: Shape, path: str = "") -> set[str]:
        here = {path + rule.field for rule in RULES[shape.record_type]}
        for _, name, part in shape.parts:
            here |= rules_under(part, f"{path}{name}.")
        for _, name, part in shape.lists:
            here |= rules_under(part, f"{path}{name}[].")
        return here

    types = [Header, *(topic.body for topic in TOPICS)]
    rules = {(t.__name__, field) for t in types for field in rules_under(shape_of(t))}
    tested = {(t.__name__, field.replace("[0]", "[]").replace("[1]", "[]")) for t, _, field in REFUSED}

    assert rules <= tested


def floats_of(value: tuple, path: str = "") -> list[tuple[str, Replace]]:
    """Every place of a float in a message, each with a function that puts another float there."""
    shape = shape_of(type(value))

    def put(name: str, inner: Replace | None = None, place: int | None = None) -> Replace:
        def changed(number: float) -> tuple:
            new = number if inner is None else inner(number)
            if place is not None:
                old = getattr(value, name)
                new = (*old[:place], new, *old[place + 1 :])
            return replace(value, **{name: new})

        return changed

    places = [(path + name, put(name)) for _, name in shape.floats]
    for _, name in shape.vectors:
        places += [(path + name, put(name, None, i)) for i in range(len(getattr(value, name)))]
    for _, name, _ in shape.parts:
        part = getattr(value, name)
        places += [(where, put(name, inner)) for where, inner in floats_of(part, f"{path}{name}.")]
    for _, name, _ in shape.lists:
        for i, element in enumerate(getattr(value, name)):
            inside = floats_of(element, f"{path}{name}[{i}].")
            places += [(where, put(name, inner, i)) for where, inner in inside]
    return places


@pytest.mark.parametrize("number", [nan, inf, -inf])
def test_non_finite_numbers_are_refused_in_every_field(body: Message, number: float) -> None:
    for field, changed in floats_of(body):
        with pytest.raises(InvalidMessageError, match="finite number") as caught:
            check("a topic", shape_of(type(body)), changed(number))
        assert caught.value.field == field


def test_the_walk_finds_every_float(body_of: dict[type, Message]) -> None:
    assert len(floats_of(body_of[PlantState])) == 2 * 4 + 3 * 2 + 3
    assert len(floats_of(body_of[FilterTick])) == 5 + 6 * 2 + (3 + 1 + 2) + 3 + 2 * 4 + 3 + (2 + 2) + 2 * 4


def test_opposite_infinities_do_not_cancel(body_of: dict[type, Message]) -> None:
    with pytest.raises(InvalidMessageError, match="finite"):
        check_changed(body_of[PlantState], {"energy_in_j": inf, "energy_stored_j": -inf})
