"""The watch over the model: silent while the sets hold, number, axis and factor where they do not."""

from typing import Any

import pytest
from passafe_protocol.messages import Event, EventKind, FilterTick, GuardAction, Message, PlantState
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

LOOP: dict[str, Any] = {"rate_hz": 200.0, "duration_s": 1.5, "filter.mode": "safe"}
SETS = {
    "parameters": {"mass": [0.9, 1.1]},
    "disturbance": {"velocity": 0.3},
    "state_error": {"position": 0.001, "velocity": 0.01},
}
WITHIN = {
    "parameters": {"mass": 1.1},
    "disturbance": {"kind": "greedy", "bound": {"velocity": 0.3}},
    "noise": {"bound": {"position": 0.001, "velocity": 0.01}},
}
LINKS: dict[str, Any] = {
    "links.plant-to-filter": {"delay_s": 0.05, "jitter_s": 0.01, "loss": 0.2, "seed": 3},
    "links.filter-to-plant": {"delay_s": 0.05, "jitter_s": 0.01, "loss": 0.2, "seed": 4},
}


def messages_of(**overrides: Any) -> list[Message]:  # noqa: ANN401 - fields of a scenario
    scenario = load_scenario("notomista-cai-2020", LOOP | {k.replace("__", "."): v for k, v in overrides.items()})
    found: list[Message] = []
    lockstep_loop(scenario, lambda _topic, _header, body: found.append(body)).run(steps_of(scenario) + 30)
    return found


@pytest.mark.parametrize("links", [{}, LINKS])
def test_a_robot_within_its_sets_is_safe_and_passes(links: dict[str, Any]) -> None:
    found = messages_of(plant__truth=WITHIN, uncertainty=SETS, plant__guard={}, **links)
    ticks = [body for body in found if isinstance(body, FilterTick)]
    states = [body for body in found if isinstance(body, PlantState) and body.true_x]
    true_at = {state.plant_ns: state.true_x for state in states}

    assert min(state.true_x[0] ** 2 + state.true_x[1] ** 2 for state in states) >= 1.0
    assert not any(isinstance(body, Event) and body.kind for body in found)
    assert max(max(tick.residual, default=0.0) for tick in ticks) <= 1.0
    assert sum(state.guard == GuardAction.CHANGED for state in states) < 0.13 * len(states)
    errors = [
        abs(truth - middle) / most
        for tick in ticks
        if tick.effective_plant_ns in true_at
        for truth, middle, most in zip(true_at[tick.effective_plant_ns], tick.x_hat, tick.x_error, strict=True)
    ]
    assert len(errors) > 500
    assert links or max(errors) <= 1.0  # under loss the fail-safe law may have come between


def test_a_heavier_robot_than_the_sets_allow_is_reported() -> None:
    truth = WITHIN | {"parameters": {"mass": 2.0}}
    sets = SETS | {"in_filter": False, "state_error": {}}
    found = messages_of(plant__truth={"parameters": truth["parameters"]}, uncertainty=sets)
    events = [body for body in found if isinstance(body, Event) and body.kind is not EventKind.TEXT]
    violated = [body for body in events if body.kind == EventKind.MODEL_VIOLATED]

    assert violated
    first = violated[0]
    assert first.severity == "error"
    assert first.number >= 1
    assert first.axis in {"x[0]", "x[1]", "x[2]", "x[3]"}
    assert first.factor > 1.0
    assert first.axis in first.text
