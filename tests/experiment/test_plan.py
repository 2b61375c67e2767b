"""Planned runs, for any known results in any order."""

from collections.abc import Callable, Iterable
from random import Random
from typing import Any

import pytest
from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.schema import Experiment
from passafe_services.tools.experiment.summary import ExperimentSummary
from studies import DELAY, study

EMPTY: dict[str, Any] = {
    **{name: None for name, field in Metrics.model_fields.items() if field.annotation not in {int, float}},
    **{name: 0 for name, field in Metrics.model_fields.items() if field.annotation in {int, float}},
    "status_counts": {},
    "properties": {},
    "verdict": "holds",
}


def result(run: Run, **metrics: object) -> RunResult:
    return RunResult(run=run, metrics=Metrics.model_validate(EMPTY | metrics), wall_s=0.1)


def bisected() -> Experiment:
    delay = {"name": "d", "kind": "bisect", "key": "plant.hold_s", "low": 0.0, "high": 1.0, "tolerance": 0.05}
    return study(axes=[DELAY, delay], seeds={"count": 3}).experiment


def h_of(run: Run) -> float:
    """Fail the first cell from 0.3 on, the other from 0.8 on, each with one seed only."""
    threshold = 0.3 if run.cell == 0 else 0.8
    return -1.0 if run.probe is not None and run.probe > threshold and run.seed == 1 else 1.0


def work(plan: Plan, order: Callable[[list[Run]], None]) -> list[Run]:
    waiting, done = list(plan.first()), []
    while waiting:
        order(waiting)
        run = waiting.pop()
        done.append(run)
        waiting += plan.after(result(run, h_min=h_of(run), tank_min_j=1.0))
    return done


def test_a_grid_wants_every_run_once_and_nothing_more() -> None:
    experiment = study(axes=[DELAY], seeds={"first": 4, "count": 3}, variants={"a": {}, "b": {}}).experiment
    plan = Plan(experiment)
    runs = list(plan.first())

    assert len({run.key for run in runs}) == len(runs) == plan.most_runs == 2 * 2 * 3
    assert {run.seed for run in runs} == {4, 5, 6}
    assert [plan.after(result(run)) for run in runs] == [[]] * 12


def test_plan_is_complete_once_nothing_is_wanted() -> None:
    experiment = bisected()
    plan = Plan(experiment)
    assert not plan.is_complete

    work(plan, lambda _waiting: None)

    assert plan.is_complete
    assert Plan(experiment, plan.results).is_complete
    more = experiment.model_copy(update={"seeds": experiment.seeds.model_copy(update={"count": 4})})
    assert not Plan(more, plan.results).is_complete


def test_runs_that_share_a_reference_follow_one_another() -> None:
    experiment = study(axes=[DELAY], seeds={"count": 2}, variants={"b": {}, "a": {}}).experiment

    order = [(run.variant, run.seed, run.values["delay_s"]) for run in Plan(experiment).first()]

    assert order == [(v, s, d) for v in ("b", "a") for s in (0, 1) for d in (0.0, 0.01)]


@pytest.mark.parametrize("seed", range(5))
def test_results_in_any_order_lead_to_the_same_runs(seed: int) -> None:
    ordered = work(Plan(bisected()), lambda waiting: waiting.reverse())
    shuffled = work(Plan(bisected()), Random(seed).shuffle)

    assert {run.key for run in shuffled} == {run.key for run in ordered}
    assert len(shuffled) == len(ordered)


def test_one_failing_seed_is_enough_to_break_a_cell() -> None:
    plan = Plan(bisected())
    done = work(plan, lambda _: None)
    first, second = (found.boundaries["safe"] for found in ExperimentSummary.of(plan).boundaries)

    assert first.holds_up_to is not None
    assert second.holds_up_to is not None
    assert 0.25 <= first.holds_up_to <= 0.3 < (first.fails_from or 0) <= 0.35
    assert 0.75 <= second.holds_up_to <= 0.8 < (second.fails_from or 0) <= 0.85
    assert plan.most_runs == len(done) == len(plan.results)


def test_what_is_known_is_not_wanted_again() -> None:
    whole = Plan(bisected())
    done = work(whole, Random(3).shuffle)
    half = dict(list(whole.results.items())[: len(done) // 2])

    rest = work(Plan(bisected(), half), lambda _: None)

    assert {run.key for run in rest} | set(half) == set(whole.results)
    assert not {run.key for run in rest} & set(half)
    assert not list(Plan(bisected(), whole.results).first())


def test_results_of_other_seeds_count_for_nothing() -> None:
    experiment = study(axes=[DELAY], seeds={"count": 3}).experiment
    plan = Plan(experiment)
    for run in list(plan.first()):
        plan.after(result(run))
    fewer = study(axes=[DELAY], seeds={"first": 1, "count": 1}).experiment

    assert {key.seed for key in Plan(fewer, plan.results).results} == {1}
    assert not list(Plan(fewer, plan.results).first())


def test_more_is_expected_of_a_bisection_until_it_has_settled() -> None:
    plan = Plan(bisected())
    waiting: Iterable[Run] = list(plan.first())
    before = plan.most_runs
    work_left = list(waiting)
    while work_left:
        run = work_left.pop()
        work_left += plan.after(result(run, h_min=1.0, tank_min_j=1.0))  # holds everywhere: five values are enough

    assert before > plan.most_runs == len(plan.results) == 2 * 5 * 3
