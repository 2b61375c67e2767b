"""Verdicts from one pass over a log, beside the same log in memory."""

from pathlib import Path

import numpy as np
import pytest
from damped_point_run import DampedPoint, Run, header, rollout, state
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.log import log_pass
from passafe_services.log.log_pass import LogPass
from passafe_services.tools.review.plant_record import TimesKept
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.run_review import RunReview, identity_of
from passafe_services.tools.review.verdict import Verdict

HOLDING, FAIL_SAFE = PlantPhase.HOLDING, PlantPhase.FAIL_SAFE


def of_one_pass(path: Path) -> Verdict:
    run = LogPass(path)
    review = RunReview(path, identity_of(run), DampedPoint(), derives=False)
    run.feed(review)
    return Verdict.concluding(review, run)


def small_run(steps: int = 300) -> Run:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda k: (0.01 * (k % 7), 0.0), steps=steps)
    return run


@pytest.mark.parametrize("missing", [(), (17, 18, 120)])
def test_many_slices_give_the_verdict_of_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: tuple[int, ...]
) -> None:
    run = small_run()
    path = run.write(
        tmp_path / "run.mcap",
        without=lambda head, body: isinstance(body, PlantState) and head.sequence in missing,
    )
    in_memory = Verdict.of(RunLog.read(path), DampedPoint(), derives=False)
    monkeypatch.setattr("passafe_services.log.log_file.CHUNK_BYTES", 4096)
    chunked = run.write(
        tmp_path / "chunked.mcap",
        without=lambda head, body: isinstance(body, PlantState) and head.sequence in missing,
    )
    monkeypatch.setattr(log_pass, "STRETCH_BYTES", 1)

    assert of_one_pass(chunked) == in_memory == of_one_pass(path)


def test_durations_of_two_plants_are_not_mixed(tmp_path: Path) -> None:
    run = Run()
    for k in range(1001):
        run.add(header("plant", k, epoch=1), state(k, (2.0, 0.0, 0.0, 0.0), (0.0, 0.0)))
    for k in range(201):  # at once with the first one
        run.add(header("plant", k, epoch=2, step=300 + k), state(k, (2.0, 0.0, 0.0, 0.0), (0.0, 0.0)))

    verdict = of_one_pass(run.write(tmp_path / "two.mcap"))

    assert verdict.duration_s == pytest.approx(1.0)


def test_durations_of_a_restarted_plant_add_up(tmp_path: Path) -> None:
    run = Run()
    for epoch, begin, steps in ((1, 0, 501), (2, 600, 301)):
        for k in range(steps):
            run.add(header("plant", k, epoch=epoch, step=begin + k), state(k, (2.0, 0, 0, 0), (0.0, 0.0)))

    assert of_one_pass(run.write(tmp_path / "two.mcap")).duration_s == pytest.approx(0.8)


def test_a_break_ends_with_its_session(tmp_path: Path) -> None:
    run = Run()
    for epoch, begin, steps in ((1, 0, 1000), (2, 1100, 10)):
        for k in range(steps):
            phase = FAIL_SAFE if epoch == 1 and k >= 900 else PlantPhase.RUNNING
            run.add(header("plant", k, epoch=epoch, step=begin + k), state(k, (2.0, 0, 0, 0), (0, 0), phase=phase))

    verdict = of_one_pass(run.write(tmp_path / "two.mcap"))

    assert verdict.sequence_breaks == 1
    assert verdict.without_input_s == pytest.approx(0.099)


def test_times_are_thinned_out_and_still_found() -> None:
    times = TimesKept()
    for begin in range(0, 400_000, 5000):
        plant_ns = np.arange(begin, begin + 5000) * 1_000_000
        times.add(plant_ns + 77, plant_ns)

    found = times.plant_s(250_000 * 1_000_000 + 77)
    assert found == pytest.approx(250.0, abs=0.008)
    assert times.plant_s(0) is None
