"""Verdicts on starts of runs, rounding, and states that no model explains."""

import math
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import DampedPoint, Run, header, rollout, scenario, state
from judged_runs import REST, coasting, judged
from passafe_protocol.messages import PlantState
from passafe_services.tools.review.properties import Tolerances
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict


@pytest.mark.parametrize(("below", "holds"), [(2e-16, True), (1e-12, False), (0.0009, False)])
def test_h_may_be_below_zero_by_its_rounding_alone(tmp_path: Path, below: float, *, holds: bool) -> None:
    run = Run()
    run.add(header("plant", 0), state(0, (math.sqrt(1 - below), 0.0, 0.0, 0.0), REST))
    verdict = judged(run, tmp_path)
    safe = verdict.properties["safe"]
    assert verdict.h_min == pytest.approx(-below, abs=3e-16)
    assert safe.holds is holds
    assert safe.allowed.startswith("≥ -")
    assert float(safe.allowed.removeprefix("≥ ")) == pytest.approx(-8e-15, rel=0.2)  # 16 units of x₁, and its square's
    generous = Verdict.of(
        RunLog.read(tmp_path / "run.mcap"), DampedPoint(), derives=False, tolerances=Tolerances(h=0.01)
    )
    assert generous.properties["safe"].holds is True
    assert generous.tolerances.h == 0.01


def test_a_start_outside_of_the_protected_set_is_said(tmp_path: Path) -> None:
    run = Run(scenario(mode="safe"))
    # At 1.2 with speed −2: h = 0.44 and ψ₁ = −4.8 + 4.4. The robot stops by itself, far inside.
    rollout(run, x0=(1.2, 0.0, -2.0, 0.0), u=lambda _: REST, steps=20)
    verdict = judged(run, tmp_path)
    start = verdict.properties["protected-start"]
    assert (start.holds, start.required, start.worst, start.at_s) == (False, False, pytest.approx(-0.4), 0.0)
    assert verdict.words == "holds: the start was outside of the protected set: ψ1 of disk was -0.4"
    assert judged(coasting(Run(scenario(mode="safe"))), tmp_path).words == "holds: violated but not required: passive"


def test_a_mode_without_safety_says_nothing_of_its_start(tmp_path: Path) -> None:
    run = Run(scenario(mode="off"))
    rollout(run, x0=(1.2, 0.0, -2.0, 0.0), u=lambda _: REST, steps=5)
    assert judged(run, tmp_path).properties["protected-start"].note == ""


@pytest.mark.parametrize(("below", "holds"), [(0.049, True), (0.051, False)])
def test_passivity_has_a_tolerance(tmp_path: Path, below: float, *, holds: bool) -> None:
    run = Run()
    away = 0.1  # h_u = 2·away² − 2·distance·away without input
    run.add(header("plant", 0), state(0, ((2 * away**2 + below) / (2 * away), 0.0, away, 0.0), REST))
    verdict = judged(run, tmp_path)
    assert verdict.power_margin_min == pytest.approx(-below)
    assert verdict.properties["passive"].holds is holds


def test_states_that_the_model_does_not_explain_fail(tmp_path: Path) -> None:
    run = Run()
    states = rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=20)
    moved = states[9] + np.array([1e-4, 0, 0, 0])
    run.replace(run.indices(PlantState)[9], x=tuple(moved))
    consistent = judged(run, tmp_path).properties["consistent"]
    assert consistent.holds is False
    assert consistent.worst == pytest.approx(1e-4 / (1 + moved[0]), rel=1e-3)
    assert consistent.at_s == pytest.approx(0.009, abs=1.1e-3)
