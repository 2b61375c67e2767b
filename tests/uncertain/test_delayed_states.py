"""The set of states in which a batch of filters expects its plants: that of the filter, with the truth in it."""

from dataclasses import replace

import numpy as np
import pytest
from passafe_services.plant_contract.state_estimate import StateEstimate
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.uncertain.delayed_states import DelayedStates
from passafe_services.tools.uncertain.trials import LINKS, SETS
from passafe_services.tools.uncertain.true_plants import TruePlants

from passafe.design import FilterDesign
from passafe.numerics.workspace import Array
from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth

TICKS = 160
COUNT = 8


def robust(sets: str) -> FilterDesign:
    scenario = load_scenario("notomista-cai-2020", {"filter.mode": "safe", "rate_hz": 250.0})
    design = design_of(scenario, robot_of(scenario))
    return replace(design, uncertainty=SETS[sets])


class Watched:
    """Members of the sets at the ends of their intervals, measured with noise, pushed and steered at random.

    Attributes:
        states: What is known of them.
        truth: Their states so far.
        measured: As they were read.
        sent: Inputs sent.
    """

    def __init__(self, link: str, *, guarded: float = 0.0) -> None:
        self.design = design = robust("together")
        self.growth = ErrorGrowth(design)
        self.rng = np.random.default_rng(4)
        self.states = DelayedStates(LINKS[link], self.growth, TICKS, [self.rng] * COUNT, design.dt_s)
        names = [each.name for each in design.system.parameters]
        ends = np.array([SETS["together"].parameters[name] for name in names])
        corners = self.rng.integers(0, 2, (len(names), COUNT))
        self.plants = TruePlants(design, np.take_along_axis(ends, corners, axis=1))
        self.truth = [self.rng.normal(size=(4, COUNT))]
        self.measured: list[Array] = []
        self.sent: list[Array] = []
        self.applied: list[Array] = []
        self.guarded = guarded

    def tick(self) -> tuple[Array, Array]:
        """Measure, return what is known of the state now, and go on by a period."""
        noise = np.array(self.growth.at_measurement)[:, None] * self.rng.choice([-1.0, 1.0, 0.3], (4, COUNT))
        self.measured.append(self.truth[-1] + noise)
        self.states.measure(self.measured[-1])
        found = self.states.predicted()
        u = self.rng.normal(scale=5.0, size=(2, COUNT))
        acts = self.rng.uniform(size=COUNT) < self.guarded
        self.sent.append(u)
        self.applied.append(np.where(acts, 0.5 * u, u))
        self.states.send(u, self.applied[-1])
        push = np.array([0.0, 0.0, 0.3, 0.3])[:, None] * self.rng.choice([-1.0, 1.0], (4, COUNT))
        self.truth.append(self.plants.advance(self.truth[-1], self.applied[-1], push)[0])
        return found


@pytest.mark.parametrize("link", LINKS)
def test_members_at_the_ends_stay_in_the_set(link: str) -> None:
    watched = Watched(link)
    for k in range(TICKS):
        center, radius = watched.tick()
        assert (np.abs(watched.truth[k] - center) <= radius + 1e-9).all()


@pytest.mark.parametrize("link", LINKS)
def test_a_guard_that_acts_leaves_the_truth_in_the_box(link: str) -> None:
    watched = Watched(link, guarded=0.2)
    for _ in range(TICKS):
        watched.tick()
        box, newest = watched.states._box, watched.states._at
        assert box is not None
        true = np.array([watched.truth[k][:, i] for i, k in enumerate(newest.tolist())]).T
        assert (np.abs(true - box[:4]) <= box[4:] + 1e-9).all()


@pytest.mark.parametrize("link", LINKS)
def test_the_set_is_that_of_the_filters_estimate(link: str) -> None:
    watched, at = Watched(link), 0
    estimate = StateEstimate(watched.growth)
    narrower = 0
    for k in range(TICKS):
        center, radius = watched.tick()
        newest = int(watched.states._at[0])
        if k == 0 or newest > at:
            inputs = None if k == 0 else [tuple(u[:, 0]) for u in watched.sent[at:newest]]
            estimate.observe(tuple(watched.measured[newest][:, 0]), inputs)
            at = newest
        assert estimate.newest is not None
        narrower += max(estimate.newest.radius) < 0.9 * max(watched.growth.at_measurement)
        expected = watched.growth.roll(estimate.newest, [tuple(u[:, 0]) for u in watched.sent[at:k]])
        np.testing.assert_allclose(center[:, 0], expected.center, atol=1e-12)
        np.testing.assert_allclose(radius[:, 0], expected.radius, atol=1e-12)
    assert narrower > 0


def test_a_reading_outside_of_the_sets_begins_the_box_anew() -> None:
    design = robust("mass")
    states = DelayedStates(LINKS["none"], ErrorGrowth(design), 9, [np.random.default_rng(1)], design.dt_s)
    plant, x = SampledPlant(design.system, design.passivity.V, design.dt_s), (1.0, 2.0, 3.0, -1.0)
    for _ in range(9):
        states.measure(np.array([x]).T)
        center, radius = states.predicted()
        assert center[:, 0].tolist() == pytest.approx(x)
        assert radius[:, 0] == pytest.approx(0.0, abs=1e-12)
        states.send(np.zeros((2, 1)), np.zeros((2, 1)))
        x = tuple(each + 0.1 for each in plant.advance(x, (0.0, 0.0)).x)
