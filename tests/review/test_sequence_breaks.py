"""Sequence breaks, from states with known phases."""

from pathlib import Path

import pytest
from damped_point_run import PERIOD_NS, WALL_NS, DampedPoint, Run, header, rollout
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.sequence_breaks import sequence_breaks
from passafe_services.tools.review.verdict import Verdict

WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


def run_of(*phases: PlantPhase) -> Run:
    """One state a period with these phases, at rest away from the disk."""
    run = Run()
    rollout(run, x0=(2.0, 0.0, 0.0, 0.0), u=lambda _: (0.0, 0.0), steps=len(phases))
    for phase, index in zip(phases, run.indices(PlantState), strict=True):
        run.replace(index, phase=phase)
    return run


def read(run: Run, tmp_path: Path) -> RunLog:
    return RunLog.read(run.write(tmp_path / "run.mcap"))


def wall_ns(step: int) -> int:
    return WALL_NS + step * PERIOD_NS


def test_break_lasts_from_the_missing_input_to_the_next_one(tmp_path: Path) -> None:
    run = run_of(WAITING, WAITING, RUNNING, HOLDING, HOLDING, FAIL_SAFE, FAIL_SAFE, RUNNING, RUNNING, HOLDING, RUNNING)
    first, second = sequence_breaks(read(run, tmp_path).of(PlantState))
    assert first == (0.003, wall_ns(3), wall_ns(5), wall_ns(7), 0.007)
    assert second == (0.009, wall_ns(9), None, wall_ns(10), 0.010)
    assert first.length_s(99.0) == pytest.approx(0.004)


def test_one_that_does_not_end_lasts_until_the_end_of_the_log(tmp_path: Path) -> None:
    log = read(run_of(RUNNING, RUNNING, FAIL_SAFE, FAIL_SAFE, FAIL_SAFE), tmp_path)
    [only] = sequence_breaks(log.of(PlantState))
    assert only == (0.002, wall_ns(2), wall_ns(2), None, None)
    verdict = Verdict.of(log, DampedPoint(), derives=False)
    assert verdict.sequence_breaks == 1
    assert verdict.without_input_s == pytest.approx(0.002)


def test_waiting_is_no_break_and_sessions_are_separate(tmp_path: Path) -> None:
    run = run_of(WAITING, RUNNING, HOLDING)
    for step, phase in enumerate((WAITING, RUNNING, RUNNING)):
        _, body = run.sent[run.indices(PlantState)[step]]
        run.add(header("plant", step, epoch=2), body)
        run.replace(-1, phase=phase)
    log = read(run, tmp_path)
    [only] = sequence_breaks(log.of(PlantState))
    assert only.resumed_s is None
    verdict = Verdict.of(log, DampedPoint(), derives=False)
    assert verdict.sessions == {"operator": 1, "filter": 1, "plant": 2}
    assert verdict.sequence_breaks == 1


def test_no_state_is_no_break() -> None:
    assert sequence_breaks([]) == []
