"""Rollouts of a batch are what each would be alone."""

import numpy as np
import pytest
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.adversaries import ADVERSARIES
from passafe_services.tools.campaign.campaign_job import BATCH, CampaignJob
from passafe_services.tools.campaign.lowest_barrier import LowestBarrier
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from scalar_rollouts import rollout

DURATION_S = 0.6
AGREEMENT = {"h_min": 1e-4, "tank_min_j": 1e-4, "overreach": 1e-3}
"""By how much metrics of a rollout may differ, m² or m, J and units of u: two certified answers of one tick differ by
1e-6 or so, in the most by 1e-3 where the limit on the norm binds, and that is carried on."""

NONLINEAR = {
    "plant.model": "drag-point",
    "plant.parameters": {"sigma": 1.0, "drag": 0.4},
    "rate_hz": 200.0,
    "filter.k_i": 50.0,
}


def assert_same(got: RolloutResult, expected: RolloutResult) -> None:
    assert (got.seed, got.adversary, got.ticks) == (expected.seed, expected.adversary, expected.ticks)
    for name, within in AGREEMENT.items():
        assert getattr(got, name) == pytest.approx(getattr(expected, name), abs=within), name
    assert got.between_samples_unproven == expected.between_samples_unproven
    for status in {*got.statuses, *expected.statuses}:
        assert abs(got.statuses.get(status, 0) - expected.statuses.get(status, 0)) <= max(3, 0.03 * got.ticks)


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if not name.startswith(("arm-", "wrong-"))])
def test_a_rollout_is_the_one_that_is_made_tick_by_tick(name: str) -> None:
    scenario, seeds = load_scenario(name), range(40, 40 + len(ADVERSARIES))
    for got in Rollouts(scenario).run(seeds, DURATION_S):
        assert_same(got, rollout(scenario, got.seed, DURATION_S))


def test_a_nonlinear_plant_rolls_as_it_does_tick_by_tick() -> None:
    scenario = load_scenario("notomista-cai-2020", NONLINEAR)
    for got in Rollouts(scenario).run(range(5), DURATION_S):
        assert_same(got, rollout(scenario, got.seed, DURATION_S))


@pytest.mark.parametrize("overrides", [{}, NONLINEAR, {"filter.mode": "off"}, {"filter.mode": "passive"}])
def test_with_scalar_decisions_it_is_the_same(overrides: dict[str, object]) -> None:
    scenario = load_scenario("notomista-cai-2020", overrides)
    at_once, scalar = (Rollouts(scenario, scalar=each).run(range(5), 0.3) for each in (False, True))
    for one, other in zip(at_once, scalar, strict=True):
        assert_same(one, other)
        assert other.decided_scalar == other.ticks > one.decided_scalar


@pytest.mark.parametrize("name", ["tight-limits", "moving-disk"])
def test_outcomes_do_not_depend_on_the_batch(name: str) -> None:
    """Alone, in another order and among others: to the last bit."""
    rollouts, seeds = Rollouts(load_scenario(name)), [17, 3, 8, 21, 4, 12, 0, 9, 26, 5]
    together = rollouts.run(seeds, 0.2)

    assert [outcome.seed for outcome in together] == seeds
    assert rollouts.run(seeds[::-1], 0.2) == together[::-1]
    assert [rollouts.run([seed], 0.2)[0] for seed in seeds] == together


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if not name.startswith(("arm-", "wrong-"))])
def test_the_lowest_h_of_a_period_is_that_of_its_instants(name: str) -> None:
    scenario = load_scenario(name)
    n, m, t_s = len(scenario.plant.x0), Rollouts(scenario)._core.design.system.m, 1.7
    rng = np.random.default_rng(5)
    x, u = rng.normal(size=(n, 12)), rng.normal(size=(m, 12)) * 100
    lowest = LowestBarrier(scenario, 12)
    instants = [lowest_after(scenario, x, u, t_s, share) for share in (0.0, 0.25, 0.5, 0.75)]

    np.testing.assert_allclose(lowest.during(x, u, t_s), np.min(instants, axis=0), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(lowest.at(x, t_s), instants[0], rtol=1e-12, atol=1e-12)
    x[0, 3] = np.nan
    assert np.isnan(lowest.during(x, u, t_s)[3])


def lowest_after(scenario: Scenario, x: np.ndarray, u: np.ndarray, t_s: float, share: float) -> np.ndarray:
    """Smallest h after a share of a period, from the functions with which logs are reviewed."""
    evaluator, offset_s = CoreEvaluator(scenario), share * scenario.dt_s
    later = evaluator.flow(x, u, offset_s) if share else x
    return evaluator.h(later, np.full(x.shape[1], t_s + offset_s)).min(axis=0)


def test_without_a_barrier_there_is_no_lowest_h() -> None:
    scenario = load_scenario("notomista-cai-2020", {"filter.barriers": []})
    lowest = LowestBarrier(scenario, 2)

    assert lowest.during(np.zeros((4, 2)), np.zeros((2, 2)), 0.0).tolist() == [np.inf] * 2
    assert lowest.at(np.zeros((4, 2)), 0.0).tolist() == [np.inf] * 2


@pytest.mark.parametrize(
    ("seeds", "workers", "size"),
    [(1, 2, 1), (7, 2, 4), (100, 2, 50), (BATCH, 1, BATCH), (2500, 2, 625), (10_000, 2, 1000)],
)
def test_batches_are_as_many_for_one_worker_as_for_another(seeds: int, workers: int, size: int) -> None:
    assert CampaignJob.of(load_scenario("notomista-cai-2020"), 1.0).batch_size(seeds, workers) == size
