"""Live beside lockstep: what is compared, and what is found out."""

from pathlib import Path
from typing import Any

import pytest
from passafe_services.cli.experiment_live import run_live, spread
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.experiment.cells import Cell, cells_of, run_of
from passafe_services.tools.experiment.errors import LiveRunError
from passafe_services.tools.experiment.live_agreement import DRAWS, TOLERANCES, compare, draws_of, until
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.timing import Lateness
from passafe_services.tools.review.verdict import Verdict
from studies import study

DELAY = {"links.plant-to-filter.delay_s": 0.02, "links.filter-to-plant.delay_s": 0.01}


def scenario(duration_s: float = 0.3, **overrides: object) -> tuple[StudyRunner, Scenario]:
    swept = study(duration_s=duration_s, overrides=DELAY | overrides)
    runner = StudyRunner(swept)
    return runner, runner.scenario_of(run_of(swept.experiment, cells_of(swept.experiment)[0], 0))


@pytest.fixture(scope="module")
def same(tmp_path_factory: pytest.TempPathFactory) -> tuple[Verdict, Metrics]:
    """Return the verdict on a log and the metrics of the same run in lockstep."""
    runner, chosen = scenario()
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    metadata = run_metadata(scenario_json=chosen.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        runner.trace(chosen, LockstepLog(log))
    verdict = Verdict.of(until(RunLog.read(path), chosen.duration_s), CoreEvaluator(chosen))
    return verdict, runner.metrics(chosen, until_its_end=True)


def test_the_same_run_agrees_in_every_metric_exactly(same: tuple[Verdict, Metrics]) -> None:
    found = compare("cell", same[0], [same[1]])
    compared = {one.metric.partition(":")[0] for one in found}

    assert [one for one in found if not one.agrees or one.difference] == []
    assert compared == {*TOLERANCES, "holds", "lateness_ms"}
    assert all(one.reason for one in found)


@pytest.mark.parametrize(
    ("changes", "metric", "difference"),
    [
        ({"h_min": -0.5}, "h_min", None),
        ({"tank_min_j": 0.5}, "tank_min_j", 0.5),
        ({"ticks": 400}, "ticks", None),
        ({"final_x": (0.0, 0.0, 0.0, 0.0)}, "final_x:0", None),
        ({"status_counts": {"STALE": 1}}, "status_share:STALE", 1 / 301),
        ({"h_min": None}, "h_min", float("inf")),
    ],
)
def test_a_metric_that_is_off_is_reported_with_its_deviation(
    changes: dict[str, Any], metric: str, difference: float | None, same: tuple[Verdict, Metrics]
) -> None:
    found = {one.metric: one for one in compare("cell", same[0].model_copy(update=changes), [same[1]])}

    assert found[metric].difference > 0
    assert difference is None or found[metric].difference == pytest.approx(difference, rel=1e-2)
    assert found[metric].agrees == (found[metric].difference <= found[metric].tolerance)
    if metric != "status_share:STALE":
        assert not found[metric].agrees


def test_with_random_links_a_live_run_must_lie_within_the_draws(
    same: tuple[Verdict, Metrics],
) -> None:
    low, high = (same[1].model_copy(update={"u_norm_max": value}) for value in (10.0, 40.0))
    within, outside = (same[0].model_copy(update={"u_norm_max": value}) for value in (25.0, 42.5))

    [one] = [one for one in compare("cell", within, [high, low]) if one.metric == "u_norm_max"]
    [other] = [one for one in compare("cell", outside, [high, low]) if one.metric == "u_norm_max"]

    assert (one.low, one.high, one.difference, one.agrees) == (10.0, 40.0, 0.0, True)
    assert (other.difference, other.agrees) == (2.5, False)


def test_a_machine_later_than_the_tolerances_allow_is_reported(same: tuple[Verdict, Metrics]) -> None:
    late = Lateness(p50=10.0, p99=100.0, p99_9=1000.0, max=7000.0)
    timing = same[0].timing.model_copy(update={"late_us": {"filter": late}})

    [*_, lateness] = compare("cell", same[0].model_copy(update={"timing": timing}), [same[1]])

    assert (lateness.metric, lateness.live, lateness.agrees) == ("lateness_ms", 7.0, False)


def test_only_random_links_are_drawn_again() -> None:
    _, delayed = scenario()
    _, lossy = scenario(**{"links.plant-to-filter.loss": 0.1})

    assert draws_of(delayed) == [delayed]
    seeds = [draw.links["plant-to-filter"].seed for draw in draws_of(lossy)]
    assert len(set(seeds)) == DRAWS
    assert lossy.links["plant-to-filter"].seed not in seeds


def test_cells_are_spread_evenly() -> None:
    cells = [Cell(number=number, variant="base", values={}) for number in range(9)]

    assert [cell.number for cell in spread(cells, 3)] == [0, 4, 8]
    assert [cell.number for cell in spread(cells, 1)] == [0]
    assert spread(cells, 20) == cells


@pytest.mark.live
@pytest.mark.alone
def test_a_live_run_is_compared_with_lockstep_in_every_metric(tmp_path: Path) -> None:
    """The differences depend on the machine; the motion of the robot does not."""
    # A play-out time in which a busy machine does not let the plant run out of inputs.
    runner, chosen = scenario(duration_s=2.0, **{"plant.playout_s": 0.3})
    verdict = run_live(chosen, tmp_path)
    lockstep = [runner.metrics(one, until_its_end=True) for one in draws_of(chosen)]
    found = {one.metric: one for one in compare("cell", verdict, lockstep)}

    assert verdict.driver == "live"
    assert verdict.duration_s == pytest.approx(2.0, abs=0.01)
    assert found["holds:safe"].agrees
    assert found["final_x:0"].live == pytest.approx(found["final_x:0"].low, abs=0.1)


@pytest.mark.live
def test_a_live_run_that_fails_says_why(tmp_path: Path) -> None:
    _, chosen = scenario(**{"operator.source": {"kind": "keyboard"}})

    with pytest.raises(LiveRunError, match="allowed a run that writes its log"):
        run_live(chosen, tmp_path)
