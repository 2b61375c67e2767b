"""The prediction against a plant that follows the rule: the next input of the series, or hold and fail-safe."""

import random
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.messages import UNSEQUENCED, PlantPhase, PlantState, Vector
from passafe_services.filter.predictor import Predictor
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant, Tank, damped_point
from passafe.limits import Limits
from passafe.sampled_plant import Sample

MS = 1_000_000
HOLD_MS = 3
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase
ROBOT = damped_point(sigma=1.0, gamma_1=10.0)


class CountedPlant(SampledPlant):
    """The model, and how often it was stepped."""

    steps = 0

    def advance(self, x: Vector, u: Vector) -> Sample:
        self.steps += 1
        return super().advance(x, u)


def make_plant() -> CountedPlant:
    return CountedPlant(ROBOT.system, ROBOT.system.x.T @ ROBOT.system.x, 1e-3)


def fail_safe() -> FailSafe:
    return FailSafe(ROBOT, Limits.of(2, 100.0), period_ns=MS, hold_ns=HOLD_MS * MS)


def make_predictor(tank: Tank | None = None) -> Predictor:
    return Predictor(make_plant(), fail_safe(), tank or Tank(), MS)


class TruePlant:
    """The plant, in a sequence from its beginning, with the input of every period or None where it is missing."""

    def __init__(self) -> None:
        self.model, self.rule = make_plant(), fail_safe()
        self.sample = self.model.at((1.0, -0.5, 0.3, 0.2))
        self.energy_in_j = 0.0
        self.k = self.since = 0
        self.u: Vector = (0.0, 0.0)
        self.phase, self.sequence_break_ns = RUNNING, UNSEQUENCED

    def advance(self, u: Vector | None) -> None:
        self.sample = self.model.advance(self.sample.x, self.u)
        self.energy_in_j += self.sample.energy_in_j
        self.k += 1
        if u is not None:
            self.u, self.phase, self.since = u, RUNNING, self.k
            return
        if self.phase is RUNNING:
            self.sequence_break_ns = self.k * MS
        self.phase, self.u = self.rule.without_input(self.u, self.since * MS, self.k * MS, self.sample.x)

    def state(self, phase: PlantPhase | None = None) -> PlantState:
        sample = self.sample
        return PlantState(
            plant_ns=self.k * MS,
            x=sample.x,
            y=sample.y,
            u=self.u,
            applied_tick=self.k,
            phase=phase or self.phase,
            energy_in_j=self.energy_in_j,
            energy_stored_j=sample.stored_j,
            input_lead_ns=0,
            inputs_late=0,
            inputs_refused=0,
            integration_error=0.0,
            received_tick=self.k,
            sequence_break_ns=self.sequence_break_ns,
            input_since_ns=self.since * MS,
        )


def random_inputs(count: int) -> list[tuple[float, float]]:
    rng = random.Random(7)
    return [(rng.uniform(-9, 9), rng.uniform(-9, 9)) for _ in range(count)]


def sent_ahead(predictor: Predictor, inputs: list[tuple[float, float]], first: int, last: int) -> dict[int, Vector]:
    """Send the inputs of some periods, as a filter does; return the state that each was decided for."""
    predicted = {}
    for k in range(first, last + 1):
        predicted[k] = predictor.predict(k * MS).sample.x
        predictor.record_sent(k * MS, inputs[k])
    return predicted


@pytest.mark.parametrize("delay", [1, 5, 40])
def test_prediction_is_bit_exact_at_one_model_step_per_tick(delay: int) -> None:
    inputs, truth, predictor = random_inputs(120), TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    sent_ahead(predictor, inputs, 1, delay - 1)
    predicted = {}
    for k in range(delay, 120):
        predicted[k] = predictor.predict(k * MS)
        predictor.record_sent(k * MS, inputs[k])
        truth.advance(inputs[truth.k + 1])
        predictor.confirm(truth.state())
        if truth.k in predicted:
            assert predicted[truth.k].sample.x == truth.sample.x
            assert predicted[truth.k].u == truth.u
    assert predictor.horizon_ns == (delay - 1) * MS
    assert predictor._plant.steps == 119


@pytest.mark.parametrize("missing", [1, 2, 7])
@pytest.mark.parametrize("late", [0, 1, 4, 9])
def test_broken_sequence_is_predicted_through_hold_and_fail_safe(missing: int, late: int) -> None:
    """The plant lacks the input of one period; the filter learns of it later and starts a new sequence at period 20."""
    inputs, truth, predictor = random_inputs(40), TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    sent_ahead(predictor, inputs, 1, 12)
    for k in range(1, missing):
        truth.advance(inputs[k])
    for _ in range(1 + late):
        truth.advance(None)
    predictor.confirm(truth.state())

    predictor.begin_sequence(20 * MS)
    at_break = predictor.predict(20 * MS)
    before_u, phase = at_break.u, at_break.phase
    predicted = sent_ahead(predictor, inputs, 20, 25)
    while truth.k < 19:
        truth.advance(None)
        predictor.confirm(truth.state())

    assert (before_u, phase, at_break.sequence_break_ns) == (truth.u, FAIL_SAFE, missing * MS)
    for k in range(20, 26):
        truth.advance(inputs[k])
        assert predicted[k] == truth.sample.x
        predictor.confirm(truth.state())


def test_sequence_with_a_gap_is_predicted_to_break_there() -> None:
    truth, predictor = TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    for k in (1, 2, 4, 5):  # 3 is never sent
        predictor._sent[k * MS] = (1.0, 1.0)

    found = predictor.predict(12 * MS)
    for u in ((1.0, 1.0), (1.0, 1.0), *[None] * 10):
        truth.advance(u)

    assert found.sample.x == truth.sample.x
    assert (found.phase, found.sequence_break_ns) == (FAIL_SAFE, 3 * MS)


def test_earlier_break_than_predicted_is_noticed() -> None:
    """Equal inputs: the plant that lacks the third holds the second, and looks as if the third were in force."""
    truth, predictor = TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    sent_ahead(predictor, [(1.0, 1.0)] * 4, 1, 3)
    predictor.predict(10 * MS)
    for u in ((1.0, 1.0), (1.0, 1.0), None, None):
        truth.advance(u)
    predictor.confirm(truth.state())

    found = predictor.predict(10 * MS)
    while truth.k < 10:
        truth.advance(None)
    assert found.sample.x == truth.sample.x


@settings(max_examples=40)
@given(st.sets(st.integers(1, 40)), st.integers(1, 12))
def test_applied_inputs_always_meet_the_predicted_state(lost: set[int], delay: int) -> None:
    """States arrive at once, inputs ``delay`` periods later; after a break the filter starts a new sequence at once."""
    inputs, truth, predictor = random_inputs(60), TruePlant(), SHARED
    predictor.restart()
    predictor.confirm(truth.state())
    predicted: dict[int, Vector] = {}
    first, next_k, basis = 1, 1, truth.sequence_break_ns
    arrived: dict[int, int] = {}  # period → plant time of the sequence's beginning
    for now in range(40):
        if truth.sequence_break_ns != basis or (truth.phase is not RUNNING and now >= first):
            first = next_k = now + delay
            basis = truth.sequence_break_ns
            predictor.begin_sequence(first * MS)
        while next_k <= now + delay:
            predicted[next_k] = predictor.predict(next_k * MS).sample.x
            predictor.record_sent(next_k * MS, inputs[next_k])
            if next_k not in lost:
                arrived[next_k] = first
            next_k += 1
        k = truth.k + 1
        follows = truth.phase is RUNNING or (k == first and truth.sequence_break_ns == basis)
        truth.advance(inputs[k] if follows and arrived.get(k) == first else None)
        predictor.confirm(truth.state())
        if truth.phase is RUNNING:
            assert truth.sample.x == predicted[truth.k]


SHARED = make_predictor()


def test_plant_at_rest_is_predicted_from_the_first_inputs_time() -> None:
    inputs, truth, predictor = random_inputs(20), TruePlant(), make_predictor()
    predictor.confirm(truth.state(WAITING))
    predictor.begin_sequence(0)
    sent_ahead(predictor, inputs, 0, 4)
    for _ in range(3):
        predictor.confirm(truth.state(WAITING))
    truth.u = inputs[0]
    for k in range(1, 5):
        predictor.confirm(truth.state())
        truth.advance(inputs[k])

    assert predictor.predict(4 * MS).sample.x == truth.sample.x
    assert predictor._plant.steps == 4


def test_the_tank_follows_the_plants_energies() -> None:
    truth, tank = TruePlant(), Tank(initial_j=1.0, reserve_j=0.5, max_j=1.5)
    predictor = make_predictor(tank)
    level, before = tank.reserve_j, truth.sample.stored_j
    predictor.confirm(truth.state())
    for k, u in enumerate(random_inputs(200), start=1):
        ahead = predictor.predict(k * MS)
        predictor.record_sent(k * MS, u)
        truth.advance(u)
        level = tank.balance(level, truth.sample.energy_in_j, truth.sample.stored_j - before)
        before = truth.sample.stored_j
        assert ahead.tank_j == pytest.approx(level, abs=1e-8)
        predictor.confirm(truth.state())


@pytest.mark.parametrize("phase", PlantPhase)
def test_only_a_plant_that_was_never_driven_has_a_full_tank(phase: PlantPhase) -> None:
    """Energy left by another filter is unknown: it counts as the reserve, which only safety uses."""
    tank = Tank(initial_j=3.0, reserve_j=0.5)
    predictor = make_predictor(tank)
    for _ in range(2):  # a plant, and the next one
        predictor.confirm(TruePlant().state(phase))
        assert predictor.predict(0).tank_j == (3.0 if phase is PlantPhase.WAITING else 0.5)
        predictor.restart()


def test_tank_follows_the_plants_energies_after_a_break() -> None:
    inputs, truth, tank = random_inputs(40), TruePlant(), Tank(initial_j=7.0, reserve_j=5.0, max_j=1000.0)
    predictor = make_predictor(tank)
    states = [truth.state()]
    predictor.confirm(states[0])
    sent_ahead(predictor, inputs, 1, 12)
    for k in range(1, 20):
        truth.advance(inputs[k] if k < 4 else None)
        states.append(truth.state())
        if k in {2, 9, 15, 19}:  # the others were lost
            predictor.confirm(states[-1])
            predictor.begin_sequence((k + 5) * MS)
    supplied = states[-1].energy_in_j - states[0].energy_in_j
    stored = states[-1].energy_stored_j - states[0].energy_stored_j

    assert predictor.predict(19 * MS).tank_j == pytest.approx(5.0 + supplied - stored, abs=1e-9)
    for before, after in pairwise(states):
        assert after.plant_ns == before.plant_ns + MS


def test_an_older_state_changes_nothing() -> None:
    truth, predictor = TruePlant(), make_predictor()
    first = truth.state()
    predictor.confirm(first)
    truth.advance((1.0, 1.0))
    predictor.confirm(truth.state())

    predictor.confirm(first)

    assert predictor._confirmed == truth.state()
    assert predictor.predict(MS).sample.x == truth.sample.x


def test_what_lies_behind_the_plant_is_forgotten() -> None:
    inputs, truth, predictor = random_inputs(200), TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    sent_ahead(predictor, inputs, 1, 10)
    for k in range(1, 190):
        truth.advance(inputs[k])
        predictor.confirm(truth.state())
        sent_ahead(predictor, inputs, k + 10, k + 10)

    assert len(predictor._sent) <= 11
    assert len(predictor._trajectory) == 11


def test_a_restart_forgets_everything() -> None:
    truth, predictor = TruePlant(), make_predictor()
    predictor.confirm(truth.state())
    sent_ahead(predictor, random_inputs(5), 1, 4)

    predictor.restart()
    assert predictor.horizon_ns == 0
    predictor.begin_sequence(0)
    predictor.confirm(truth.state())

    assert predictor.predict(0).sample.x == truth.sample.x
    assert predictor._sent == {}
