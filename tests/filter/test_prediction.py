import random

import pytest

from passafe import SampledPlant, Tank, damped_point
from protocol.messages import PlantPhase, PlantState
from services.filter.prediction import Predictor

MS = 1_000_000


def make_plant() -> SampledPlant:
    robot = damped_point(sigma=1.0)
    return SampledPlant(robot.system, robot.system.x.T @ robot.system.x, 1e-3)


class TruePlant:
    """The plant itself, with inputs by the period in which they are applied."""

    def __init__(self) -> None:
        self.model = make_plant()
        self.sample = self.model.at((1.0, -0.5, 0.3, 0.2))
        self.energy_in_j = 0.0
        self.k = 0
        self.u = (0.0, 0.0)

    def advance(self, u: tuple[float, ...]) -> None:
        self.sample = self.model.advance(self.sample.x, self.u)
        self.energy_in_j += self.sample.energy_in_j
        self.k += 1
        self.u = u

    def state(self) -> PlantState:
        sample = self.sample
        return PlantState(
            self.k * MS,
            sample.x,
            sample.y,
            self.u,
            self.k,
            PlantPhase.RUNNING,
            self.energy_in_j,
            sample.stored_j,
            0,
            0,
            0,
            0.0,
            self.k,
        )


def random_inputs(count: int) -> list[tuple[float, float]]:
    rng = random.Random(7)
    return [(rng.uniform(-9, 9), rng.uniform(-9, 9)) for _ in range(count)]


@pytest.mark.parametrize("delay", [1, 5, 40])
def test_the_prediction_is_what_the_plant_does_to_the_last_bit(delay: int) -> None:
    inputs = random_inputs(120)
    truth, tank = TruePlant(), Tank()
    predictor = Predictor(make_plant(), tank, MS)
    predictor.confirm(truth.state())
    for k in range(1, delay):
        predictor.sent(k * MS, inputs[k])
    foreseen = {}
    for k in range(delay, 120):
        foreseen[k] = predictor.at(k * MS)
        predictor.sent(k * MS, inputs[k])
        truth.advance(inputs[truth.k + 1])
        predictor.confirm(truth.state())
        if truth.k in foreseen:
            assert foreseen[truth.k].sample.x == truth.sample.x
    assert predictor.horizon_ns == (delay - 1) * MS


def test_a_lost_input_is_corrected_by_the_next_state() -> None:
    truth = TruePlant()
    predictor = Predictor(make_plant(), Tank(), MS)
    predictor.confirm(truth.state())
    for k in range(1, 10):
        predictor.at(k * MS)
        predictor.sent(k * MS, (5.0, 5.0))
    truth.advance((0.0, 0.0))  # the plant held the old input instead
    predictor.confirm(truth.state())

    found = predictor.at(3 * MS)

    expected = truth.model.advance(truth.sample.x, (0.0, 0.0))
    expected = truth.model.advance(expected.x, (5.0, 5.0))
    assert found.sample.x == expected.x


def test_the_tank_follows_the_plants_energies() -> None:
    truth, tank = TruePlant(), Tank(initial_j=1.0, reserve_j=0.5, max_j=1.5)
    predictor = Predictor(make_plant(), tank, MS)
    level, before = tank.initial_j, truth.sample.stored_j
    predictor.confirm(truth.state())
    for k, u in enumerate(random_inputs(200), start=1):
        ahead = predictor.at(k * MS)
        predictor.sent(k * MS, u)
        truth.advance(u)
        level = tank.balance(level, truth.sample.energy_in_j, truth.sample.stored_j - before)
        before = truth.sample.stored_j
        assert ahead.tank_j == pytest.approx(level, abs=1e-8)
        predictor.confirm(truth.state())


def test_an_older_state_changes_nothing() -> None:
    truth = TruePlant()
    first = truth.state()
    predictor = Predictor(make_plant(), Tank(), MS)
    predictor.confirm(first)
    truth.advance((1.0, 1.0))
    predictor.confirm(truth.state())

    predictor.confirm(first)

    assert predictor.confirmed == truth.state()
