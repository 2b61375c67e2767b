"""A verdict says that an emergency stop stood the robot, and none holds on a run that ended stopped."""

from pathlib import Path

from damped_point_run import DampedPoint, Run, rollout
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.cli.verdict import exit_code
from passafe_services.tools.review.emergency_stops import StopStretch, emergency_stops
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

STEPS = 1_800


def stopped_run(*stretches: tuple[int, int, str]) -> Run:
    """Return a run of 1.8 s at rest with a stop latched from one step to another."""
    run = Run()
    rollout(run, x0=(2.0, 0.5, 0.0, 0.0), u=lambda _: (0.0, 0.0), steps=STEPS)
    indices = run.indices(PlantState)
    for number, (begin, end, source) in enumerate(stretches, start=1):
        for index in indices[begin:end]:
            run.replace(index, stop=number, stop_source=source, phase=PlantPhase.FAIL_SAFE)
    return run


def log_of(run: Run, folder: Path) -> RunLog:
    return RunLog.read(run.write(folder / "run.mcap"))


def test_stretches_are_found_with_their_ends(tmp_path: Path) -> None:
    log = log_of(stopped_run((300, 500, "console"), (1_700, 1_800, "operator")), tmp_path)

    assert emergency_stops(log.of(PlantState)) == [
        StopStretch(0.3, 0.2, "console", is_cleared=True),
        StopStretch(1.7, 0.099, "operator", is_cleared=False),
    ]


def test_a_run_without_a_stop_says_nothing_of_one(tmp_path: Path) -> None:
    assert "emergency" not in Verdict.of(log_of(stopped_run(), tmp_path), DampedPoint(), derives=False).words


def test_a_run_that_ended_stopped_does_not_hold(tmp_path: Path) -> None:
    """The robot stood for a tenth of a second only, which alone would be a run like any other."""
    verdict = Verdict.of(log_of(stopped_run((1_700, 1_800, "dashboard")), tmp_path), DampedPoint(), derives=False)

    assert verdict.verdict == "fails"
    assert "an emergency stop (dashboard) was latched from 1.700 s on and not cleared" in verdict.words
    assert exit_code(verdict) == 1


def test_a_cleared_stop_is_named_in_a_verdict_that_holds(tmp_path: Path) -> None:
    run = stopped_run((300, 400, "console"), (500, 510, "console"), (700, 900, "operator"))
    verdict = Verdict.of(log_of(run, tmp_path), DampedPoint(), derives=False)

    assert verdict.verdict == "holds"
    assert verdict.words.startswith(
        "holds: an emergency stop (console) was latched from 0.300 s on for 0.1 s, 1 more were latched and cleared, "
        "an emergency stop (operator) was latched from 0.700 s on for 0.2 s"
    )
