"""Uncertain campaigns: a short, seeded slice of ``make uncertain-campaign``, and what it is made of."""

from pathlib import Path

import numpy as np
import pytest
from passafe_services.cli import campaign as campaign_command
from passafe_services.cli.app import app
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.uncertain.adversaries import STRENGTH, Adversaries
from passafe_services.tools.uncertain.delayed_states import DelayedStates
from passafe_services.tools.uncertain.summary import TrialSummary, UncertainSummary
from passafe_services.tools.uncertain.trials import LINKS, SETS, UncertainTrial, all_trials
from passafe_services.tools.uncertain.true_plants import LowestLevel, TruePlants
from passafe_services.tools.uncertain.uncertain_job import BATCH, UncertainJob
from passafe_services.tools.uncertain.uncertain_result import UncertainResult
from typer.testing import CliRunner

from passafe.barrier_chain import derive_chain
from passafe.design import FilterDesign
from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth

HELD = UncertainTrial(scenario="notomista-cai-2020", sets="together", link="100+100", protection="both")
SEEDS = (0, 2, 5, 6, 7, 10)


def paper(**sets: object) -> FilterDesign:
    scenario = load_scenario("notomista-cai-2020", {"filter.mode": "safe", "rate_hz": 250.0})
    design = design_of(scenario, robot_of(scenario))
    return FilterDesign(**{name: getattr(design, name) for name in GIVEN} | sets)  # type: ignore[arg-type]  # parts by name


GIVEN = ("system", "u_fb", "fail_safe", "barriers", "passivity", "k_i", "dt_s", "input_bound", "mode")


def results(cell: UncertainTrial, seeds: tuple[int, ...], duration_s: float) -> list[UncertainResult]:
    return UncertainJob(cell=cell, duration_s=duration_s).compile()(seeds)


def test_rows_and_guard_keep_what_the_model_alone_does_not() -> None:
    kept, lost = (
        results(
            UncertainTrial(scenario=HELD.scenario, sets="mass", link="100+100", protection=protection), (0, 1, 2), 1.0
        )
        for protection in ("rows", "none")
    )
    assert min(result.h_min for result in kept) >= 0.0 > min(result.h_min for result in lost)


def test_a_rollout_does_not_depend_on_its_batch() -> None:
    run = UncertainJob(cell=HELD, duration_s=0.2).compile()
    together = run(SEEDS)

    assert [result.seed for result in together] == list(SEEDS)
    assert [run([seed])[0] for seed in SEEDS[:2]] == together[:2]
    assert all(result.h_min > 0 and max(result.x_error_max) > 0.01 for result in together)


def test_cells_are_every_combination() -> None:
    cells = all_trials()
    assert len({cell.name for cell in cells}) == len(cells) == 2 * 5 * 3 * 4
    assert {cell.is_promised for cell in cells if not cell.has_guard and not cell.has_robust_filter} == {False}


@pytest.mark.parametrize(("seeds", "workers", "size"), [(10, 2, 5), (10_000, 2, BATCH)])
def test_batches_are_bounded(seeds: int, workers: int, size: int) -> None:
    assert UncertainJob(cell=HELD, duration_s=1.0).batch_size(seeds, workers) == size


@pytest.mark.parametrize(("link", "age"), [("none", 0), ("100+100", 50)])
def test_the_newest_state_is_as_old_as_both_delays(link: str, age: int) -> None:
    """With the inputs zero and the model exact, the predicted state is the one that the plant would have."""
    design = paper(uncertainty=SETS["mass"])
    states = DelayedStates(LINKS[link], ErrorGrowth(design), 80, [np.random.default_rng(1)] * 2, design.dt_s)
    plant, x, zero = SampledPlant(design.system, design.passivity.V, design.dt_s), (1.0, 2.0, 3.0, -1.0), (0.0, 0.0)
    for k in range(80):
        states.measure(np.array([x, x]).T + (k == 80 - 1 - age))
        predicted, error = states.predicted()
        if k < 80 - 1 - age:
            assert predicted[:, 0] == pytest.approx(x, abs=1e-12)
        assert (error == 0).all()
        states.send(np.zeros((2, 2)), np.zeros((2, 2)))
        x = plant.advance(x, zero).x
    assert predicted[0, 0] > x[0] + 0.5  # the state that was off by one has arrived by now, and none after it


def test_lost_states_leave_the_newest_as_it_is() -> None:
    design = paper(uncertainty=SETS["noise"])
    states = DelayedStates(LINKS["200+200"], ErrorGrowth(design), 400, [np.random.default_rng(3)], design.dt_s)
    ahead = round(0.25 / design.dt_s)
    ages = [k - int(states._newest[max(k - ahead, 0)][0]) for k in range(400)]
    assert min(ages[200:]) >= 0.4 / design.dt_s
    assert 0.5 / design.dt_s >= max(ages[200:]) > min(ages[200:])


def test_true_plants_are_pushed_and_have_their_own_mass() -> None:
    design = paper()
    plants = TruePlants(design, np.array([[1.0, 2.0], [1.0, 1.0]]))
    x = np.array([[2.0, 2.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    after, h = plants.advance(x, np.full((2, 2), 4.0), np.array([[0.0] * 2, [0.0] * 2, [1.0] * 2, [0.0] * 2]))

    gained = 1 - np.exp(-design.dt_s)
    np.testing.assert_allclose(after[2], [5.0 * gained, 3.0 * gained], rtol=1e-9)
    np.testing.assert_allclose(after[3], [4.0 * gained, 2.0 * gained], rtol=1e-9)
    np.testing.assert_allclose(h, [3.0, 3.0], atol=1e-3)


def test_the_lowest_level_leads_away_from_the_disk() -> None:
    design = paper()
    chain = derive_chain(design.system, design.barriers[0])
    lowest = LowestLevel(design, chain.psi[0], 2)
    x = np.array([[1.5, 0.0], [0.0, -1.1], [0.0, 0.0], [0.0, 0.0]])

    np.testing.assert_allclose(lowest.slope(x), 2 * x)
    np.testing.assert_allclose(lowest.gap(x), [1.25 / 3.0, 0.21 / 2.2])


def test_adversaries_keep_within_their_bounds() -> None:
    design, seeds, bounds = paper(), range(9), np.array([0.0, 0.0, 0.3, 0.2])
    rngs = [np.random.default_rng(seed) for seed in seeds]
    x = np.random.default_rng(0).normal(size=(4, 9))
    adversaries = Adversaries(seeds, rngs, x, bounds)
    lowest = LowestLevel(design, derive_chain(design.system, design.barriers[0]).psi[1], 9)
    into = np.tile([[1.0], [0.0]], 9)
    asked, pushed = [], []
    for t_s in np.arange(0.0, 3.0, 0.05).tolist():
        asked.append(adversaries.ask(t_s, into).copy())
        pushed.append(adversaries.push(t_s, x, lowest).copy())
    assert (np.abs(pushed) <= bounds[:, None]).all()
    np.testing.assert_allclose(np.linalg.norm(asked, axis=1), STRENGTH)
    changes = (np.ptp(asked, axis=0) > 0).any(axis=0)
    assert [kind == "switching" for kind in adversaries.operators] == changes.tolist()
    assert (np.asarray(asked)[:, :, np.array(adversaries.operators) == "greedy"][:, 0] == STRENGTH).all()


def result(seed: int, h_min: float, **changes: object) -> UncertainResult:
    parts: dict[str, object] = {
        "seed": seed,
        "operator": "constant",
        "disturbance": "greedy",
        "h_min": h_min,
        "gap_m": 0.01 * seed,
        "guarded_share": 0.5,
        "fallback_share": 0.0,
        "x_error_max": (0.0,),
    }
    return UncertainResult.model_validate(parts | changes)


def test_a_summary_names_the_worst_seed() -> None:
    cell = TrialSummary.of(HELD, [result(1, 0.1), result(2, -0.2), result(3, 0.3), result(4, 0.1, operator="greedy")])

    assert (cell.safe, cell.rollouts, cell.h_worst, cell.worst_seed) == (3, 4, -0.2, 2)
    assert cell.stand_off_m == pytest.approx(0.02)
    assert not UncertainSummary(cells=(cell,)).holds
    assert UncertainSummary(cells=(cell.model_copy(update={"is_promised": False}),)).holds
    assert np.isnan(TrialSummary.of(HELD, [result(1, 0.1, operator="greedy")]).stand_off_m)


def test_the_command_resumes_and_prints_every_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign_command, "all_trials", lambda: [HELD])
    arguments = ["campaign", "--uncertain", "-n", "2", "-d", "0.05", "-o", str(tmp_path), "--workers", "1"]
    for _ in range(2):
        outcome = CliRunner().invoke(app, arguments)
        assert outcome.exit_code == 0, outcome.output
    assert "2/2" in outcome.output
    assert len((tmp_path / f"{HELD.name}.jsonl").read_text().splitlines()) == 3
    assert UncertainSummary.model_validate_json((tmp_path / "uncertain.summary.json").read_text()).holds


def test_scenarios_and_uncertain_exclude_each_other(tmp_path: Path) -> None:
    outcome = CliRunner().invoke(app, ["campaign", "notomista-cai-2020", "--uncertain", "-o", str(tmp_path)])
    assert "scenarios and --uncertain" in str(outcome.exception)
