"""Campaigns: a short, seeded slice of what ``make campaign`` runs, and what surrounds it."""

from contextlib import closing
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tools.campaign.adversaries import ADVERSARIES, STRENGTH
from passafe_services.tools.campaign.campaign_job import CampaignJob, campaign_results
from passafe_services.tools.campaign.errors import NoSafeStartError
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.campaign.summary import CampaignSummary
from passafe_services.tools.runs.errors import ResultsFileError
from passafe_services.tools.runs.summary import Spread
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.runs.worker_processes import WorkerProcesses

from passafe import SafetyPassivityFilter
from passafe.batch.batch_filter import BatchFilter

NAME = "notomista-cai-2020"
SLICE_S = 2.0


def outcome(seed: int, **changes: object) -> RolloutResult:
    parts: dict[str, object] = {
        "seed": seed,
        "adversary": "chirp",
        "h_min": 0.1,
        "tank_min_j": 0.5,
        "overreach": -1.0,
        "ticks": 10,
        "statuses": {"PASSED": 8, "MODIFIED": 2},
        "between_samples_unproven": 0,
        "decided_scalar": 1,
    }
    return RolloutResult.model_validate(parts | changes)


@pytest.fixture(
    scope="module", params=[name for name in shipped_scenarios() if not name.startswith(("arm-", "wrong-"))]
)
def rollouts(request: pytest.FixtureRequest) -> Rollouts:
    return Rollouts(load_scenario(request.param))


def test_every_shipped_scenario_holds_against_every_adversary(rollouts: Rollouts) -> None:
    results = rollouts.run(range(20), SLICE_S)

    assert [result.seed for result in results] == list(range(20))
    assert {result.adversary for result in results} == set(ADVERSARIES)
    for result in results:
        assert result.h_min >= 0
        assert result.tank_min_j >= 0
        assert result.overreach <= 1e-12
        assert result.between_samples_unproven == 0
        assert result.ticks == sum(result.statuses.values()) == round(SLICE_S * rollouts.scenario.rate_hz)
        assert 1 <= result.decided_scalar < result.ticks / 2


def test_a_seed_decides_everything() -> None:
    first, second = Rollouts(load_scenario(NAME)), Rollouts(load_scenario(NAME))
    one = first.run([3], 0.5)
    first.run([1], 0.1)

    assert first.run([3], 0.5) == one == second.run([3], 0.5)
    assert first.run([8], 0.5)[0].h_min != one[0].h_min


def test_without_the_filter_the_campaign_sees_what_happens() -> None:
    unprotected = Rollouts(load_scenario(NAME, {"filter.mode": "off"}))
    summary = CampaignSummary.of(NAME, [*unprotected.run(range(5), 3.0)])

    assert not summary.holds
    assert summary.unsafe > 0
    assert summary.worst["h_min"].value < -0.5


def test_the_adversary_against_h_finds_the_hole_between_samples() -> None:
    """At 50 Hz the rows alone leave a hole between samples; the margin closes it."""
    slow: dict[str, object] = {"rate_hz": 50.0, "filter.k_i": 20.0}
    with_margin, without = (
        Rollouts(load_scenario(NAME, slow | {"filter.between_samples": on})).run([3], 10.0)[0] for on in (True, False)
    )

    assert with_margin.h_min >= 0 > without.h_min


def test_a_box_without_a_safe_start_is_refused() -> None:
    inside = {"plant.start_low": [-0.1, -0.1, 0.0, 0.0], "plant.start_high": [0.1, 0.1, 0.0, 0.0]}
    with pytest.raises(NoSafeStartError, match=r"plant\.start_low"):
        Rollouts(load_scenario(NAME, inside)).run([0], 0.1)


def decided(x: tuple[float, ...], count: int) -> BatchFilter:
    """Return the reference scenario's filter at rest in one state, in every element."""
    scenario = load_scenario(NAME)
    many = BatchFilter(SafetyPassivityFilter(design_of(scenario, robot_of(scenario))), count)
    zero = np.zeros((2, count))
    many.decide(np.tile(np.array(x)[:, None], count), zero, zero, zero)
    return many


@pytest.mark.parametrize("name", ADVERSARIES)
def test_adversaries_ask_for_no_more_than_their_strength(name: str) -> None:
    many, asked, none = decided((1.2, 0.3, -0.5, 0.1), 3), [], np.zeros((2, 3))
    ask = ADVERSARIES[name]([np.random.default_rng(4 + i) for i in range(3)], 2, slice(0, 3))
    for k in range(300):
        asked.append(ask(k * 0.01, many if k else None).copy())
        many.decide(np.tile(np.array([[1.2], [0.3], [-0.5], [0.1]]), 3), none, asked[-1], none)

    assert np.shape(asked) == (300, 2, 3)
    assert np.abs(asked).max() <= STRENGTH * (1 + 1e-12)
    assert np.abs(asked).max(axis=(0, 1)).min() > 1.0


def test_against_h_pushes_into_the_tightest_row() -> None:
    many, rngs = decided((1.2, 0.0, -0.5, 0.0), 4), [np.random.default_rng(0)] * 2
    against_h, against_tank = (
        ADVERSARIES[name](rngs, 2, slice(1, 3))(0.0, many) for name in ("against-h", "against-the-tank")
    )

    np.testing.assert_allclose(against_h, [[-STRENGTH, -STRENGTH], [0.0, 0.0]], atol=1e-12)
    assert against_tank[0] == pytest.approx([-STRENGTH] * 2)  # power margin falls with yᵀu − ∇Vᵀf


def test_rows_that_are_equally_tight_are_pushed_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever of them rounding leaves a hair tighter: or the solver would decide what a seed stands for."""
    many = decided((1.2, 0.0, -0.5, 0.0), 3)
    monkeypatch.setattr(BatchFilter, "hard", 2)
    many.part("margins")[:2, :3] = [[1e-9, 0.0, 1e-3], [0.0, 1e-9, 0.0]]
    many.gradients[:, :2] = np.array([[1.0, 0.0], [0.0, 1.0]])[:, :, None]
    asked = ADVERSARIES["against-h"]([np.random.default_rng(0)] * 3, 2, slice(0, 3))(0.0, many)

    assert asked.T.tolist() == [[-STRENGTH, 0.0], [-STRENGTH, 0.0], [0.0, -STRENGTH]]


@pytest.mark.parametrize("mode", ["off", "safe", "passive"])
def test_adversaries_without_their_row_take_the_first_axis(mode: str) -> None:
    scenario = load_scenario(NAME, {"filter.mode": mode})
    many = BatchFilter(SafetyPassivityFilter(design_of(scenario, robot_of(scenario))), 1)
    zero = np.zeros((2, 1))
    many.decide(np.array([[1.2], [0.3], [-0.5], [0.1]]), zero, zero, zero)
    first_axis = {
        name: np.array_equal(ADVERSARIES[name]([np.random.default_rng(0)], 2, slice(0, 1))(0.0, many), [[20.0], [0.0]])
        for name in ("against-h", "against-the-tank")
    }

    assert first_axis == {"against-h": mode != "safe", "against-the-tank": mode != "passive"}


def test_worker_processes_give_what_one_process_gives() -> None:
    job = CampaignJob.of(load_scenario(NAME), 0.2)

    with closing(WorkerProcesses(job, 2)) as pool:
        two = [*chain.from_iterable(sweep(FixedPlan(range(7)), pool, lambda _: job.batch_size(7, 2)))]

    assert sorted(two, key=lambda result: result.seed) == job.compile()(range(7))


def test_a_box_without_a_safe_start_ends_the_campaign() -> None:
    inside = {"plant.start_low": [-0.1, -0.1, 0.0, 0.0], "plant.start_high": [0.1, 0.1, 0.0, 0.0]}
    job = CampaignJob.of(load_scenario(NAME, inside), 0.1)

    with closing(WorkerProcesses(job, 1)) as pool, pytest.raises(NoSafeStartError, match=r"plant\.start_low") as caught:
        list(sweep(FixedPlan([0]), pool, lambda _: 1))

    assert caught.value.field == "plant.start_low, plant.start_high"


def test_the_summary_names_the_seed_of_each_worst() -> None:
    summary = CampaignSummary.of(
        NAME,
        [
            outcome(0),
            outcome(1, h_min=0.01, statuses={"INFEASIBLE": 1, "PASSED": 9}),
            outcome(2, tank_min_j=0.2, overreach=-0.5),
        ],
    )

    assert {name: worst.seed for name, worst in summary.worst.items()} == {"h_min": 1, "tank_min_j": 2, "overreach": 2}
    assert summary.metrics["h_min"] == Spread(min=0.01, median=0.1, max=0.1)
    assert (summary.rollouts, summary.ticks) == (3, 30)
    assert summary.statuses == {"PASSED": 25, "MODIFIED": 4, "INFEASIBLE": 1}
    assert summary.rollouts_with["INFEASIBLE"] == 1
    assert summary.decided_scalar == 3
    assert summary.holds


@pytest.mark.parametrize(
    "changes", [{"h_min": -1e-15}, {"tank_min_j": -1e-9}, {"overreach": 1e-9}, {"between_samples_unproven": 1}]
)
def test_one_bad_rollout_is_enough(changes: dict[str, object]) -> None:
    assert not CampaignSummary.of(NAME, [outcome(0), outcome(1, **changes)]).holds


def test_an_interrupted_campaign_resumes(tmp_path: Path) -> None:
    path, scenario = tmp_path / "a.jsonl", load_scenario(NAME)
    assert len(list(campaign_results(path, scenario, 1.0).add([[outcome(0)], [outcome(1), outcome(3)]]))) == 2

    again = campaign_results(path, scenario, 1.0)

    assert again.results == {seed: outcome(seed) for seed in (0, 1, 3)}


@pytest.mark.parametrize(("overrides", "duration_s"), [({}, 2.0), ({"rate_hz": 500.0}, 1.0)])
def test_results_of_another_campaign_are_refused(
    overrides: dict[str, object], duration_s: float, tmp_path: Path
) -> None:
    campaign_results(tmp_path / "a.jsonl", load_scenario(NAME), 1.0)

    with pytest.raises(ResultsFileError, match="results of another campaign or version"):
        campaign_results(tmp_path / "a.jsonl", load_scenario(NAME, overrides), duration_s)


def test_a_rollout_without_a_barrier_is_read_again(tmp_path: Path) -> None:
    path, scenario = tmp_path / "a.jsonl", load_scenario(NAME, {"filter.barriers": []})
    list(campaign_results(path, scenario, 1.0).add([[outcome(0, h_min=float("inf"))]]))

    assert campaign_results(path, scenario, 1.0).results[0].h_min == float("inf")
