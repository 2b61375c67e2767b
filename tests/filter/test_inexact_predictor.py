"""Prediction of a plant that is not its model: as the exact one where it is, at a bounded cost where it is not."""

from typing import Any

import numpy as np
import pytest
from passafe_protocol.messages import UNSEQUENCED, PlantPhase, PlantState
from passafe_protocol.topics import STATE, TICK
from passafe_services.filter.inexact_predictor import MOST_AT_ONCE, InexactPredictor
from passafe_services.filter.telemetry import TickRecord
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.design import tank_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

from passafe.sampled_plant import Sample, SampledPlant

MS = 1_000_000
LINKS: dict[str, Any] = {
    "links.plant-to-filter": {"delay_s": 0.1, "jitter_s": 0.02, "loss": 0.2, "seed": 3},
    "links.filter-to-plant": {"delay_s": 0.1, "jitter_s": 0.02, "loss": 0.2, "seed": 4},
}


class CountedPlant:
    """Counts the periods that a predictor computes."""

    def __init__(self, plant: SampledPlant) -> None:
        self._plant = plant
        self.periods = 0

    def advance(self, x: tuple[float, ...], u: tuple[float, ...]) -> Sample:
        self.periods += 1
        return self._plant.advance(x, u)


@pytest.fixture(scope="module")
def model() -> PlantModel:
    return PlantModel.of(load_scenario("notomista-cai-2020"))


def predictor_of(model: PlantModel) -> tuple[InexactPredictor, CountedPlant]:
    plant: Any = CountedPlant(model.dynamics)
    return InexactPredictor(plant, model.fail_safe, tank_of(model.scenario), MS), plant


def state_at(
    ms: int,
    x: tuple[float, ...],
    u: tuple[float, ...] = (0.0, 0.0),
    phase: PlantPhase = PlantPhase.RUNNING,
    break_ns: int = UNSEQUENCED,
    u_asked: tuple[float, ...] = (),
) -> PlantState:
    times = {"sequence_break_ns": break_ns, "input_since_ns": ms * MS}
    return PlantState(ms * MS, x, x[2:], u, 0, phase, 0.0, 0.0, 0, 0, 0, 0.0, 0, **times, u_asked=u_asked)


@pytest.mark.parametrize("links", [{}, LINKS])
def test_a_plant_that_is_its_model_is_predicted_alike(links: dict[str, Any]) -> None:
    decided: list[list[tuple[int, tuple[float, ...]]]] = []
    for more in ({}, {"plant.truth": {}}):
        overrides = {"rate_hz": 200.0, "duration_s": 2.0, "filter.mode": "safe", **links, **more}
        scenario = load_scenario("notomista-cai-2020", overrides)
        ticks: list[tuple[int, tuple[float, ...]]] = []

        def keep(record: TickRecord, ticks: list[tuple[int, tuple[float, ...]]] = ticks) -> None:
            ticks.append((record.effective_plant_ns, record.decision.u))

        lockstep_loop(scenario, taps={TICK: keep}).run(steps_of(scenario))
        decided.append(ticks)

    exact, inexact = decided
    assert len(exact) > 300
    assert [at_ns for at_ns, _ in exact] == [at_ns for at_ns, _ in inexact]
    np.testing.assert_allclose([u for _, u in exact], [u for _, u in inexact], atol=1e-9)


def test_each_tick_costs_no_more_than_its_budget(model: PlantModel) -> None:
    predictor, plant = predictor_of(model)
    horizon, x = 500, (2.0, 2.0, 0.0, 0.0)
    predictor.confirm(state_at(0, x, phase=PlantPhase.WAITING))
    predictor.begin_sequence(0)
    for ms in range(horizon):
        predictor.predict(ms * MS)
        predictor.record_sent(ms * MS, (1.0, 0.0))
    costs: list[int] = []
    for ms in range(200):
        before = plant.periods
        predictor.confirm(state_at(ms, (2.0 + 0.01 * ms, 2.0, 0.0, 0.0), (1.0, 0.0)))
        reached = predictor.predict((horizon + ms) * MS).sample.x[0]
        predictor.record_sent((horizon + ms) * MS, (1.0, 0.0))
        costs.append(plant.periods - before)
        assert predictor.horizon_ns == horizon * MS

    assert max(costs) <= MOST_AT_ONCE + 1
    ticks_behind = (2.0 + 0.01 * 199 + moved_in(model, horizon) - reached) / 0.01
    assert 0 <= ticks_behind <= 2 * horizon / (MOST_AT_ONCE - 1) + 1


def moved_in(model: PlantModel, periods: int) -> float:
    x = (0.0, 0.0, 0.0, 0.0)
    for _ in range(periods):
        x = model.dynamics.advance(x, (1.0, 0.0)).x
    return x[0]


def test_a_break_of_the_sequence_voids_the_course(model: PlantModel) -> None:
    predictor, _ = predictor_of(model)
    predictor.confirm(state_at(0, (2.0, 2.0, 0.0, 0.0), phase=PlantPhase.WAITING))
    predictor.begin_sequence(0)
    for ms in range(20):
        predictor.predict(ms * MS)
        predictor.record_sent(ms * MS, (1.0, 0.0))

    predictor.confirm(state_at(5, (2.0, 2.0, 0.0, 1.0), phase=PlantPhase.FAIL_SAFE, break_ns=4 * MS))
    found = predictor.predict(19 * MS)

    assert found.phase is PlantPhase.FAIL_SAFE
    assert found.sample.x[3] < 1.0


def test_an_older_state_is_ignored_and_a_restart_forgets(model: PlantModel) -> None:
    predictor, _ = predictor_of(model)
    predictor.confirm(state_at(5, (2.0, 2.0, 0.0, 0.0)))
    predictor.confirm(state_at(4, (9.0, 9.0, 0.0, 0.0)))

    assert predictor.predict(5 * MS).sample.x[0] == 2.0

    predictor.restart()
    assert predictor.horizon_ns == 0
    with pytest.raises(RuntimeError, match="no plant state"):
        predictor.predict(6 * MS)


def test_prediction_begins_with_the_guarded_input(model: PlantModel) -> None:
    predictor, _ = predictor_of(model)
    x = (2.0, 2.0, 0.0, 0.0)
    predictor.confirm(state_at(0, x, (5.0, 0.0), u_asked=(1.0, 0.0)))

    assert predictor.predict(MS).sample.x == model.dynamics.advance(x, (5.0, 0.0)).x


def test_a_disturbed_plant_under_delay_keeps_its_sequence() -> None:
    truth = {"parameters": {"mass": 1.1}, "noise": {"bound": {"velocity": 0.01}}}
    overrides = {"rate_hz": 200.0, "duration_s": 1.5, "plant.truth": truth, **LINKS}
    scenario = load_scenario("notomista-cai-2020", overrides)
    phases: list[PlantPhase] = []
    lockstep_loop(scenario, taps={STATE: lambda state: phases.append(state.phase)}).run(steps_of(scenario) + 40)

    assert phases.count(PlantPhase.RUNNING) > 250
