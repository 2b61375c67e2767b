"""The tank from states and inputs alone, and what its reserve may be short of."""

import math
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import DampedPoint, Run, rollout, scenario
from passafe_protocol.messages import FilterTick, PlantPhase, PlantState
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

REST = (0.0, 0.0)
TANK = {"tank_initial_j": 1.0, "tank_reserve_j": 0.75, "tank_max_j": 10.0}


def coasting(steps: int = 300) -> Run:
    """Return a run in which the robot coasts outward, and V grows: E = 1 − (2 + s)² − (1 − s)² + 5, s = 1 − e⁻ᵗ."""
    run = Run(scenario(mode="passive", kind="tank", passivity=TANK | {"kind": "tank"}))
    rollout(run, x0=(2.0, 0.0, 1.0, 0.0), u=lambda _: REST, steps=steps)
    return run


def judged(run: Run, tmp_path: Path) -> Verdict:
    return Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)


def energy(run: Run, tmp_path: Path) -> Property:
    return judged(run, tmp_path).properties["energy"]


def level_j(t_s: float) -> float:
    s = 1 - math.exp(-t_s)
    return 1 - ((2 + s) ** 2 + (1 - s) ** 2 - 5)


def test_what_falls_below_the_reserve_must_have_been_granted(tmp_path: Path) -> None:
    found = energy(coasting(), tmp_path)

    assert (found.required, found.holds) == (True, False)
    assert found.worst == pytest.approx(level_j(0.299) - 0.75)
    assert judged(coasting(100), tmp_path).verdict == "holds"  # E = 0.81 J after 99 ms


@pytest.mark.parametrize(("slack_w", "holds"), [(2.5, True), (0.5, False)])
def test_slack_of_each_period_counts_from_then_on(tmp_path: Path, slack_w: float, *, holds: bool) -> None:
    run = coasting()
    for index in run.indices(FilterTick)[100:]:
        run.replace(index, slack=slack_w)
    found = energy(run, tmp_path)

    granted = [level_j(k * 1e-4) - 0.75 + slack_w * max(k * 1e-4 - 0.1, 0) for k in range(2991)]
    assert found.holds is holds
    assert found.worst == pytest.approx(min(granted), abs=1e-9)


def test_energies_in_the_log_are_claims_and_change_nothing(tmp_path: Path) -> None:
    run = coasting()
    for index in run.indices(PlantState)[10:]:
        run.replace(index, energy_in_j=100.0)
    verdict = judged(run, tmp_path)

    assert verdict.tank_min_j == pytest.approx(level_j(0.299))
    assert verdict.properties["energy"].holds is False


def test_the_plants_own_law_takes_what_the_filter_never_granted(tmp_path: Path) -> None:
    run = coasting()
    for index in run.indices(PlantState)[100:]:
        run.replace(index, phase=PlantPhase.HOLDING)
    found = energy(run, tmp_path)

    assert found.holds is True
    assert found.worst == pytest.approx(level_j(0.1) - 0.75)


def test_two_sessions_of_a_plant_leave_the_slack_unknown(tmp_path: Path) -> None:
    run, again = coasting(10), coasting(10)
    for head, body in again.sent:
        if isinstance(body, PlantState):
            run.add(head.__class__(head.source, 2, *(getattr(head, name) for name in head.__struct_fields__[2:])), body)

    assert energy(run, tmp_path).holds is None


def test_a_dip_between_two_samples_is_found(tmp_path: Path) -> None:
    run = Run(scenario(mode="passive", kind="tank", passivity=TANK | {"kind": "tank"}))
    # One period of 1 s under u = −1.5 from (2, 0) at speed 1: V rises first, and E with the way back.
    rollout(run, x0=(2.0, 0.0, 1.0, 0.0), u=lambda _: (-1.5, 0.0), steps=2, period=1000)
    verdict = judged(run, tmp_path)
    x, u = np.array([[2.0], [0.0], [1.0], [0.0]]), np.array([[-1.5], [0.0]])
    gains = [float(DampedPoint().energy_gain(x, u, k / 10)[0]) for k in range(11)]

    assert min(gains[1:10]) < min(gains[0], gains[10])
    assert verdict.tank_min_j == pytest.approx(1 + min(gains))


def test_the_cores_energy_is_that_of_the_formula() -> None:
    random = np.random.default_rng(4)
    x, u = random.normal(size=(4, 20)), random.normal(scale=10, size=(2, 20))
    core, closed = CoreEvaluator(scenario()), DampedPoint()

    assert core.energy_gain(x, u, 0.02) == pytest.approx(closed.energy_gain(x, u, 0.02), abs=1e-12)
