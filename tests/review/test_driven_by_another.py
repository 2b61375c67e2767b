"""Runs in which the robot stood, was driven by another, or was not recorded: none of them holds."""

from collections.abc import Callable
from pathlib import Path

import pytest
from damped_point_run import DampedPoint, Run, header, rollout, state
from passafe_protocol.messages import FilterStatus, FilterTick, PlantPhase, PlantState
from passafe_services.cli.verdict import exit_code
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

STEPS = 2_400
REST = (0.0, 0.0)


def resting() -> Run:
    """Return a run of 2.4 s that holds: a robot that comes to rest before the disk."""
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=STEPS)
    for index in run.indices(PlantState):
        run.replace(index, input_epoch=1)
    return run


def verdict_on(run: Run, folder: Path) -> Verdict:
    return Verdict.of(RunLog.read(run.write(folder / "run.mcap")), DampedPoint(), derives=False)


def test_the_run_itself_holds(tmp_path: Path) -> None:
    verdict = verdict_on(resting(), tmp_path)

    assert verdict.words == "holds"
    assert exit_code(verdict) == 0


def change(run: Run, body: type, from_step: int, **fields: object) -> None:
    for index in run.indices(body)[from_step:]:
        run.replace(index, **fields)


def stood_to_the_end(run: Run) -> None:
    change(run, PlantState, 1_200, phase=PlantPhase.FAIL_SAFE)


def never_moved(run: Run) -> None:
    change(run, PlantState, 0, phase=PlantPhase.WAITING)


def lost_its_operator(run: Run) -> None:
    change(run, FilterTick, 1_200, status=FilterStatus.STALE)


def had_a_stranger_s_input(run: Run) -> None:
    change(run, PlantState, 2_399, input_epoch=99)


def had_an_input_of_no_tick(run: Run) -> None:
    change(run, FilterTick, 2_399, u=(1e-12, 0.0))


def had_two_plants(run: Run) -> None:
    for step in range(100, 200):
        run.add(header("plant", step - 100, epoch=2, step=step), state(step, (3.0, 0.0, 0.0, 0.0), REST))


@pytest.mark.parametrize(
    ("happened", "said"),
    [
        (stood_to_the_end, "the robot stood without an input of the filter for the last 1.2 s"),
        (never_moved, "the robot never had an input of the filter"),
        (lost_its_operator, "no fresh command came in the last 1.2 s"),
        (had_a_stranger_s_input, "the robot was driven by another: "),
        (had_an_input_of_no_tick, "driven by another: 1 states with an input that no tick of the log decided"),
        (had_two_plants, "states of two plants came at once, for 0.099 s"),
    ],
)
def test_it_does_not_hold(happened: Callable[[Run], None], said: str, tmp_path: Path) -> None:
    run = resting()
    happened(run)
    verdict = verdict_on(run, tmp_path)

    assert verdict.verdict != "holds"
    assert exit_code(verdict) != 0
    assert said in verdict.words


def test_plants_in_turn_are_one_robot(tmp_path: Path) -> None:
    run = resting()
    for number in range(100):
        step = STEPS + 500 + number
        run.add(header("plant", number, epoch=2, step=step), state(number, (3.0, 0.0, 0.0, 0.0), REST))

    assert "two plants" not in verdict_on(run, tmp_path).words


def test_ticks_that_the_log_lost_are_nobody_else_s(tmp_path: Path) -> None:
    run = resting()
    lost = set(run.indices(FilterTick)[1_000:1_100])
    run.sent = [message for index, message in enumerate(run.sent) if index not in lost]
    verdict = verdict_on(run, tmp_path)

    assert verdict.properties["driven"].holds
    assert verdict.verdict == "unproven"


def test_share_of_the_run_is_said_with_a_verdict_that_holds(tmp_path: Path) -> None:
    run = resting()
    for index in run.indices(PlantState)[:1_200]:
        run.replace(index, phase=PlantPhase.HOLDING)
    for index in run.indices(FilterTick)[:700]:
        run.replace(index, status=FilterStatus.STALE)

    assert verdict_on(run, tmp_path).words == (
        "holds: the robot was without an input of the filter for 50 % of the run and without a fresh command for 29 % "
        "of the ticks"
    )
