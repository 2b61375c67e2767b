"""Campaigns: a short, seeded slice of what ``make campaign`` runs, and what surrounds it."""

from pathlib import Path

import numpy as np
import pytest

from passafe import SafetyPassivityFilter
from services.campaign.adversaries import ADVERSARIES, STRENGTH
from services.campaign.errors import NoSafeStartError, RecordsError
from services.campaign.records import Heading, Records
from services.campaign.rollout import Outcome, Rollouts
from services.campaign.summary import Summary
from services.campaign.workers import outcomes
from services.scenarios.design import design_of, robot_of
from services.scenarios.load import load_scenario, shipped_scenarios

NAME = "notomista-cai-2020"
SLICE_S = 2.0


def outcome(seed: int, **changes: object) -> Outcome:
    parts: dict[str, object] = {
        "seed": seed,
        "adversary": "chirp",
        "h_min": 0.1,
        "tank_min_j": 0.5,
        "overreach": -1.0,
        "ticks": 10,
        "statuses": {"PASSED": 8, "MODIFIED": 2},
        "between_samples_unproven": 0,
    }
    return Outcome.model_validate(parts | changes)


@pytest.fixture(scope="module", params=shipped_scenarios())
def rollouts(request: pytest.FixtureRequest) -> Rollouts:
    return Rollouts(load_scenario(request.param))


@pytest.mark.parametrize("seed", range(len(ADVERSARIES)))
def test_every_shipped_scenario_holds_against_every_adversary(rollouts: Rollouts, seed: int) -> None:
    result = rollouts.run(seed, SLICE_S)

    assert result.h_min >= 0
    assert result.tank_min_j >= 0
    assert result.overreach <= 1e-12
    assert result.between_samples_unproven == 0
    assert result.ticks == sum(result.statuses.values()) == round(SLICE_S * rollouts.scenario.rate_hz)


def test_a_seed_decides_everything() -> None:
    first, second = Rollouts(load_scenario(NAME)), Rollouts(load_scenario(NAME))
    one = first.run(3, 0.5)
    first.run(1, 0.1)

    assert first.run(3, 0.5) == one == second.run(3, 0.5)
    assert first.run(8, 0.5).h_min != one.h_min


def test_without_the_filter_the_campaign_sees_what_happens() -> None:
    unprotected = Rollouts(load_scenario(NAME, {"filter.mode": "off"}))
    summary = Summary.of(NAME, [unprotected.run(seed, 3.0) for seed in range(5)])

    assert not summary.holds
    assert summary.unsafe > 0
    assert summary.h_min.value < -0.5


def test_the_adversary_against_h_finds_what_is_wrong_without_a_margin() -> None:
    """At 50 Hz the rows alone leave a hole between samples; the margin closes it."""
    slow: dict[str, object] = {"rate_hz": 50.0, "filter.k_i": 20.0}
    holes = [Rollouts(load_scenario(NAME, slow | {"filter.between_samples": on})).run(3, 10.0) for on in (True, False)]

    assert holes[0].h_min >= 0 > holes[1].h_min


def test_a_box_without_a_safe_start_is_refused() -> None:
    inside = {"plant.start_low": [-0.1, -0.1, 0.0, 0.0], "plant.start_high": [0.1, 0.1, 0.0, 0.0]}
    with pytest.raises(NoSafeStartError, match=r"plant\.start_low"):
        Rollouts(load_scenario(NAME, inside)).run(0, 0.1)


@pytest.mark.parametrize("name", ADVERSARIES)
def test_adversaries_ask_for_no_more_than_their_strength(name: str) -> None:
    core = SafetyPassivityFilter(design_of(load_scenario(NAME), robot_of(load_scenario(NAME))))
    ask = ADVERSARIES[name](np.random.default_rng(4), 2)
    decision = None
    asked = []
    for k in range(500):
        asked.append(ask(k * 0.01, decision))
        decision = core.decide((1.2, 0.3, -0.5, 0.1), (0.0, 0.0), asked[-1].tolist(), (0.0, 0.0))

    assert np.abs(asked).max() <= STRENGTH * (1 + 1e-12)
    assert np.abs(asked).max() > 1.0


def test_against_h_pushes_into_the_tightest_row() -> None:
    core = SafetyPassivityFilter(design_of(load_scenario(NAME), robot_of(load_scenario(NAME))))
    decision = core.decide((1.2, 0.0, -0.5, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))

    assert ADVERSARIES["against-h"](np.random.default_rng(0), 2)(0.0, decision) == pytest.approx([-STRENGTH, 0.0])
    into_the_tank = ADVERSARIES["against-the-tank"](np.random.default_rng(0), 2)(0.0, decision)
    assert into_the_tank[0] == pytest.approx(-STRENGTH)  # power margin falls with yᵀu − ∇Vᵀf


def test_worker_processes_give_what_one_process_gives() -> None:
    scenario = load_scenario(NAME)

    assert list(outcomes(scenario, range(6), 0.2, 2)) == list(outcomes(scenario, range(6), 0.2, 1))


def test_the_summary_names_the_seed_of_each_worst() -> None:
    summary = Summary.of(
        NAME,
        [
            outcome(0),
            outcome(1, h_min=0.01, statuses={"INFEASIBLE": 1, "PASSED": 9}),
            outcome(2, tank_min_j=0.2, overreach=-0.5),
        ],
    )

    assert (summary.h_min.seed, summary.tank_min_j.seed, summary.overreach.seed) == (1, 2, 2)
    assert (summary.rollouts, summary.ticks) == (3, 30)
    assert summary.statuses == {"PASSED": 25, "MODIFIED": 4, "INFEASIBLE": 1}
    assert summary.rollouts_with["INFEASIBLE"] == 1
    assert summary.holds


@pytest.mark.parametrize(
    "changes", [{"h_min": -1e-15}, {"tank_min_j": -1e-9}, {"overreach": 1e-9}, {"between_samples_unproven": 1}]
)
def test_one_bad_rollout_is_enough(changes: dict[str, object]) -> None:
    assert not Summary.of(NAME, [outcome(0), outcome(1, **changes)]).holds


def test_an_interrupted_campaign_goes_on(tmp_path: Path) -> None:
    path, heading = tmp_path / "a.jsonl", Heading(scenario=load_scenario(NAME), duration_s=1.0)
    assert len(list(Records(path, heading).add(iter([outcome(0), outcome(1)])))) == 2
    with path.open("a", encoding="utf-8") as file:
        file.write('{"seed": 2, "adv')  # killed while it wrote

    again = Records(path, heading)
    assert sorted(again.outcomes) == [0, 1]
    list(again.add(iter([outcome(2)])))
    assert sorted(Records(path, heading).outcomes) == [0, 1, 2]


def test_another_campaign_s_outcomes_are_not_mixed_in(tmp_path: Path) -> None:
    path, scenario = tmp_path / "a.jsonl", load_scenario(NAME)
    Records(path, Heading(scenario=scenario, duration_s=1.0))
    with pytest.raises(RecordsError, match="another scenario, duration"):
        Records(path, Heading(scenario=scenario, duration_s=2.0))
    path.write_text("nonsense\n", encoding="utf-8")
    with pytest.raises(RecordsError, match="no campaign"):
        Records(path, Heading(scenario=scenario, duration_s=1.0))
