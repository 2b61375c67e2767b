"""Changes of what states and ticks report besides the motion and the decision are found and named, too."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from changed_logs import Recorded, more, of_all, of_one, plus, verdict_on, walls_with
from msgspec.structs import replace
from passafe_protocol.messages import (
    FilterTick,
    GuardAction,
    Header,
    Message,
    OperatorCommand,
    OverrideReport,
    PlantPhase,
    PlantState,
)

LINKS = {
    "plant-to-filter": {"delay_s": 0.02, "jitter_s": 0.005, "loss": 0.1},
    "filter-to-plant": {"delay_s": 0.02, "outages_s": [[0.22, 0.32]]},
}


@pytest.fixture(scope="module")
def walls(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return walls_with(LINKS, tmp_path_factory.mktemp("log"))


def first_of(field: str, **changes: Callable[[Any], object]) -> dict[str, Callable[[FilterTick], object]]:
    def change(body: FilterTick) -> object:
        first, *others = getattr(body, field) or (None,)
        if first is None:
            return ()
        return replace(first, **{name: of(getattr(first, name)) for name, of in changes.items()}), *others

    return {field: change}


def override(**changes: Callable[[OverrideReport], object]) -> dict[str, Callable[[FilterTick], object]]:
    return {"override": lambda b: replace(b.override, **{name: of(b.override) for name, of in changes.items()})}


def in_phase(phase: PlantPhase, **changes: Callable[[Any], object]) -> Callable[[Header, Any], Message]:
    """Change fields of every state in a phase."""

    def change(_header: Header, body: Any) -> Message:  # noqa: ANN401 - of every kind
        if type(body) is not PlantState or body.phase is not phase:
            return body
        return replace(body, **{name: of(body) for name, of in changes.items()})

    return change


STATES: dict[str, tuple[Callable[[Header, Any], Message], str]] = {
    "phase of one": (of_one(PlantState, phase=lambda _: PlantPhase.HOLDING), "without a sequence break"),
    "time of the input": (
        of_one(PlantState, input_since_ns=more("input_since_ns")),
        "RUNNING with an input of another",
    ),
    "time of the break": (
        of_one(PlantState, sequence_break_ns=more("sequence_break_ns")),
        "sequence_break_ns goes back",
    ),
    "late inputs": (of_one(PlantState, inputs_late=more("inputs_late")), "inputs_late goes back"),
    "refused inputs": (of_one(PlantState, inputs_refused=more("inputs_refused")), "inputs_refused goes back"),
    "stops": (of_one(PlantState, stops_cleared=more("stops_cleared")), "stops_cleared goes back"),
    "emergency stop": (of_one(PlantState, stop=more("stop")), "emergency stop of nobody"),
    "stop and its source": (
        of_one(PlantState, stop=more("stop"), stop_source=lambda _: "console"),
        "an input under an emergency stop",
    ),
    "guard": (of_one(PlantState, guard=lambda _: GuardAction.CHANGED), "a guard's cause without its act"),
    "guard of all": (of_all(PlantState, guard=lambda _: GuardAction.PASSED), "a guard that the scenario does not have"),
    "received tick": (of_one(PlantState, received_tick=lambda _: 0), "never received"),
    "integration error": (of_one(PlantState, integration_error=lambda _: 0.01), "integration error"),
    "law": (in_phase(PlantPhase.FAIL_SAFE, u=plus("u", 1e-3)), "fail-safe law"),
    "held input": (in_phase(PlantPhase.HOLDING, applied_tick=lambda _: 0), "HOLDING with another applied_tick"),
}
TICKS: dict[str, tuple[Callable[[Header, Any], Message], str]] = {
    "margin of a barrier": (of_one(FilterTick, **first_of("barriers", eps=lambda eps: eps + 0.1)), "margin ε"),
    "name of a barrier": (of_one(FilterTick, **first_of("barriers", name=lambda _: "x")), "other names"),
    "name of a row": (of_one(FilterTick, **first_of("rows", name=lambda _: "x")), "other names"),
    "active row": (of_one(FilterTick, **first_of("rows", active=lambda was: not was)), "active row"),
    "share of a row": (of_one(FilterTick, **first_of("rows", share=lambda was: was + 0.1)), "share of a row"),
    "relaxed row": (of_one(FilterTick, **first_of("rows", relaxed=lambda was: was + 0.1)), "relaxed row"),
    "held back": (of_one(FilterTick, **override(held_back=plus("held_back", 0.1))), "held back"),
    "allowed": (
        of_one(FilterTick, **override(allowed_fraction=lambda b: abs(b.allowed_fraction - 0.5))),
        "allowed fraction",
    ),
    "unavoidable": (of_one(FilterTick, **override(unavoidable=lambda b: not b.unavoidable)), "unavoidable"),
}


CONSUMED: dict[str, tuple[Callable[[Header, Any], Message], str]] = {
    "age of the state": (of_one(FilterTick, state_age_ns=more("state_age_ns")), "age of the state"),
    "age of the command": (of_one(FilterTick, command_age_ns=more("command_age_ns")), "age of the command"),
    "horizon": (of_one(FilterTick, horizon_ns=more("horizon_ns")), "horizon"),
    "u_h of one command": (of_one(OperatorCommand, u_h=plus("u_h", 1e-3)), "u_h differs by 0.001"),
    "dead-man of one command": (of_one(OperatorCommand, enabled=lambda _: False), "counts, and was released"),
    "state of the command": (of_one(FilterTick, command_state=lambda _: "released"), "was released, and is held"),
    "silent command": (of_one(FilterTick, command_state=lambda _: "silent"), "does not count, and is fresh"),
    "share": (of_one(FilterTick, command_share=lambda _: 0.5), "share of a command"),
    "consumed nothing": (of_all(FilterTick, consumed=lambda _: ()), "an age of no state"),
    "another message": (of_all(FilterTick, **first_of("consumed", sequence=lambda was: was + 1)), "consumed twice"),
    "another session": (of_one(FilterTick, **first_of("consumed", epoch=lambda was: was + 1)), "no message"),
    "another topic": (of_one(FilterTick, **first_of("consumed", topic=lambda _: "input")), "does not read"),
    "another term": (of_one(FilterTick, **first_of("consumed", term=lambda was: was + 1)), "another term"),
    "received later": (of_one(FilterTick, **first_of("consumed", received_ns=lambda was: was + 10**9)), "came after"),
}
OF_PROPERTY = {"states-agree": STATES, "decisions-agree": TICKS, "ticks-agree": CONSUMED}


@pytest.mark.parametrize(
    ("property_name", "name"), [(of, name) for of, changes in OF_PROPERTY.items() for name in changes]
)
def test_a_change_is_found_and_named(
    walls: Recorded, property_name: str, name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    change, part = OF_PROPERTY[property_name][name]
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "changed.mcap", change))

    entry = verdict.properties[property_name]
    assert entry.holds is False
    assert part in entry.note or any(part in violation.text for violation in entry.violations)
    assert verdict.verdict == "fails"


def test_an_unchanged_log_agrees(walls: Recorded, tmp_path_factory: pytest.TempPathFactory) -> None:
    phases = {body.phase for _, body in walls.messages if isinstance(body, PlantState)}
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "same.mcap"))

    assert phases == {PlantPhase.WAITING, PlantPhase.RUNNING, PlantPhase.HOLDING, PlantPhase.FAIL_SAFE}
    assert verdict.properties["states-agree"].note == ""
    assert verdict.properties["decisions-agree"].note == ""
    assert verdict.properties["ticks-agree"].note == ""


def test_held_back_is_that_of_the_logged_input(walls: Recorded, tmp_path: Path) -> None:
    """An accepted answer may differ from another one; what is held back differs by more, where the gain is small."""
    gain = walls.scenario.dt_s * walls.scenario.filter.k_i
    apart = 1e-3
    assert apart / gain > 5e-3
    changes = {"u": plus("u", apart), "v": plus("v", apart / walls.scenario.dt_s)}
    both = of_one(FilterTick, **changes, **override(held_back=plus("held_back", apart / gain)))

    entry = verdict_on(walls.write(tmp_path / "apart.mcap", both)).properties["decisions-agree"]
    texts = [violation.text for violation in entry.violations]

    assert not any("held back" in text for text in texts), texts


def with_a_stall(run: Recorded) -> Recorded:
    """Return a run whose robot went on by its own clock: the plant left out the states up to a held input of theirs."""
    states = [(header, body) for header, body in run.messages if isinstance(body, PlantState)]
    held = next(
        k
        for k, ((_, before), (_, body)) in enumerate(pairwise(states))
        if (before.phase, body.phase) == (PlantPhase.RUNNING, PlantPhase.HOLDING)
    )
    first, left_out = states[held - 4][0].sequence, 5
    kept = []
    for header, body in run.messages:
        number = header.sequence
        if not isinstance(body, PlantState) or number < first:
            kept.append((header, body))
        elif number >= first + left_out:
            kept.append((replace(header, sequence=number - left_out), body))
    return Recorded(run.scenario, kept)


def test_held_input_may_have_begun_in_a_stall(walls: Recorded, tmp_path: Path) -> None:
    entry = verdict_on(with_a_stall(walls).write(tmp_path / "stall.mcap")).properties["states-agree"]

    assert not any("HOLDING" in violation.text for violation in entry.violations)


def test_input_held_after_a_stall_began_in_it_or_was_in_force(walls: Recorded, tmp_path: Path) -> None:
    change = in_phase(PlantPhase.HOLDING, input_since_ns=lambda body: body.input_since_ns - 20_000_000)
    log = with_a_stall(walls).write(tmp_path / "changed.mcap", change)

    entry = verdict_on(log).properties["states-agree"]
    assert any("HOLDING with another input_since_ns" in violation.text for violation in entry.violations)
