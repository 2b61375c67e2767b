"""Scores of steering, on trajectories whose scores are known in closed form."""

from math import exp, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.source_schema import Target
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.steering import Leg, Steering
from passafe_services.tools.review.verdict import Verdict

T_S = np.linspace(0.0, 8.0, 8001)
HERE = Target(at_s=0.0, position=(0.0, 0.0))


def leg_of(*coordinates: np.ndarray, target: Target = HERE, tolerance: float = 0.1, t_s: np.ndarray = T_S) -> Leg:
    return Leg.of(target, tolerance, t_s, np.array(coordinates))


def test_decay_settles_when_it_stays_within_the_tolerance() -> None:
    """e^{−t}·(3, 4) has the distance 5e^{−t}: ln 50 until 0.1, and 25(1 − e^{−16})/16 as mean square."""
    leg = leg_of(3 * np.exp(-T_S), 4 * np.exp(-T_S))

    assert leg.time_to_target_s == pytest.approx(np.log(50), abs=1e-3)
    assert leg.overshoot == 0.0
    assert leg.rms_error == pytest.approx(sqrt(25 * (1 - exp(-16)) / 16), rel=1e-6)


def test_oscillation_has_its_overshoot_and_settling_time() -> None:
    """e^{−t}cos 2πt: the first minimum is where tan 2πt = −1/2π; a passage through the target is no arrival."""
    leg = leg_of(np.exp(-T_S) * np.cos(2 * pi * T_S), 0 * T_S, tolerance=0.05)
    lowest_s = 0.5 - np.arctan(1 / (2 * pi)) / (2 * pi)
    after_last = np.abs(np.exp(-T_S) * np.cos(2 * pi * T_S)) > 0.05

    assert leg.overshoot == pytest.approx(-exp(-lowest_s) * np.cos(2 * pi * lowest_s), rel=1e-5)
    assert leg.time_to_target_s == pytest.approx(T_S[after_last].max(), abs=1.1e-3)
    assert leg.time_to_target_s > 2.0


def test_overshoot_is_measured_along_the_line_to_the_target() -> None:
    along = np.where(T_S < 4, -2.0 + T_S, 0.0)  # from −2 past 0 to +2, then back at once
    beside = 5 * np.sin(T_S)

    assert leg_of(along, beside).overshoot == pytest.approx(2.0, abs=2e-3)


def test_a_robot_that_is_not_there_at_the_end_was_not_there() -> None:
    near = np.where(T_S < 7.9995, 0.0, 1.0)

    assert leg_of(near, 0 * T_S).time_to_target_s is None
    assert leg_of(0 * T_S, 0 * T_S).time_to_target_s == 0.0
    assert leg_of(np.where(T_S > 3, np.nan, 0.0), 0 * T_S).time_to_target_s is None


def test_who_begins_at_the_target_overshoots_by_leaving_it() -> None:
    assert leg_of(np.sin(T_S), 0 * T_S).overshoot == pytest.approx(1.0, abs=1e-6)


def test_time_to_target_counts_from_the_targets_time() -> None:
    late = Target(at_s=1.5, position=(0.0,))  # while no state came
    after = T_S[T_S >= 2.0]
    leg = leg_of(np.exp(2.0 - after), target=late, t_s=after)

    assert leg.time_to_target_s == pytest.approx(0.5 + np.log(10), abs=1e-3)


def test_legs_end_where_the_next_target_begins() -> None:
    targets = (Target(at_s=1.0, position=(1.0,)), Target(at_s=4.0, position=(3.0,)), Target(at_s=9.0, position=(5.0,)))
    position = np.where(T_S < 3.9, 1.0, 3.0)[None]  # leaves the first a little too early
    scores = Steering.of(targets, 0.1, T_S, position)

    assert scores is not None
    assert [leg.time_to_target_s for leg in scores.legs] == [None, 0.0]
    assert scores.reached == 1
    assert scores.overshoot == scores.legs[0].overshoot == pytest.approx(2.0)
    assert scores.rms_error == pytest.approx(sqrt(4 * 0.1 / 7), rel=1e-2)
    assert Steering.of(targets[2:], 0.1, T_S, position) is None
    punctual = Steering.of(targets, 0.1, T_S, np.where(T_S < 4.0, 1.0, 3.0)[None])
    assert punctual is not None
    assert punctual.reached == 2


def test_effort_is_what_is_held_from_each_time_to_the_next() -> None:
    requested = np.array([0.0, 0.5, 2.0]), np.array([[3.0, 1.0, 7.0], [4.0, 0.0, 7.0]])
    held_back = requested[0], np.array([[0.0, 2.0, 9.0], [0.0, 0.0, 9.0]])
    scores = Steering.of([HERE], 0.1, T_S, np.zeros((2, 8001)), requested=requested, held_back=held_back)

    assert scores is not None
    assert scores.effort == pytest.approx(25 * 0.5 + 1 * 1.5)
    assert scores.held_back == pytest.approx(4 * 1.5)
    assert (scores.collisions, scores.collided_s) == (0, 0.0)


def test_collisions_are_counted_once_each_for_any_barrier() -> None:
    """Two barriers, one below zero in [1, 2), the other in [1.5, 3) and [5, 5.5): two collisions of 2.5 s."""
    first = np.where((T_S >= 1) & (T_S < 2), -1.0, 1.0)
    second = np.where(((T_S >= 1.5) & (T_S < 3)) | ((T_S >= 5) & (T_S < 5.5)), -1.0, 1.0)
    scores = Steering.of([HERE], 0.1, T_S, np.zeros((2, 8001)), h=np.array([first, second]))

    assert scores is not None
    assert (scores.effort, scores.held_back) == (None, None)
    assert scores.collisions == 2
    assert scores.collided_s == pytest.approx(2.5, abs=2e-3)


def test_only_simulated_persons_have_steering_metrics(tmp_path: Path) -> None:
    verdicts = []
    for name in ("human-steers", "walls-and-disks"):
        scenario = load_scenario(name, {"duration_s": 4.0, "filter.mode": "off"})
        metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
        with LogWriter(tmp_path / f"{name}.mcap", metadata) as log:
            lockstep_loop(scenario, observer=LockstepLog(log)).run(steps_of(scenario))
        read = RunLog.read(tmp_path / f"{name}.mcap")
        verdicts.append(Verdict.of(read, CoreEvaluator(scenario)))

    assert verdicts[1].steering is None
    scores = verdicts[0].steering
    assert scores is not None
    assert [leg.at_s for leg in scores.legs] == [0.0]
    assert scores.reached == 1
    assert scores.legs[0].time_to_target_s == pytest.approx(2.5, abs=0.3)
    assert scores.collisions == 0
    assert scores.effort is not None
    assert scores.held_back is not None
    assert scores.effort > 10.0
    assert scores.held_back < 0.1
    assert Verdict.model_validate_json(verdicts[0].model_dump_json()) == verdicts[0]
