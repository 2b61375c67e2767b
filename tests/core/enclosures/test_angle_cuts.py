"""Barriers and storage functions that contain an angle, which jumps where its cut is crossed."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import gains

from passafe.barrier_chain import Barrier
from passafe.checks.design_check import formula_findings
from passafe.decision import Status
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity
from passafe.state_set import ErrorGrowth
from passafe.system import System
from passafe.uncertainty import Uncertainty

POINT = damped_point()
BEARING = ca.atan2(POINT.position[1], POINT.position[0])
AWAY, AT_CUT = (-1.0, 0.2, 0.0, -2.0), (-1.0, 0.01, 0.0, -2.0)
SETS = Uncertainty(state_error=(1e-4,) * 4)
SLIPPING = Uncertainty(disturbance=(0.0, 0.1, 0.0))


def bearing_design(**changes: object) -> FilterDesign:
    """Return a point whose bearing is to stay above −2.5 rad: h is 5.6 on one side of the cut and −0.6 on the other."""
    parts: dict[str, object] = {
        "system": POINT.system,
        "fail_safe": -8 * POINT.velocity,
        "barriers": [Barrier(name="bearing", h=2.5 + BEARING, class_k=gains(4, 4, 4))],
        "passivity": Passivity(V=ca.sumsqr(POINT.velocity) / 2),
        "k_i": 50.0,
        "dt_s": 0.01,
        "input_bound": 15.0,
        "mode": "safe",
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types


@pytest.mark.parametrize("sets", [None, SETS], ids=["model", "sets"])
def test_nothing_is_certified_within_reach_of_a_cut(sets: Uncertainty | None) -> None:
    core = SafetyPassivityFilter(bearing_design(uncertainty=sets))

    away, at_cut = (core.decide(x, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)) for x in (AWAY, AT_CUT))

    assert away.status is Status.PASSED
    assert at_cut.status is Status.AT_SAMPLES


def test_no_course_over_a_cut_is_proven() -> None:
    core = SafetyPassivityFilter(bearing_design())
    assert core.rollout is not None
    turning = np.array([0.0, 1.2])  # for a period, in which the point crosses the line y = y₀ − 5e-6 twice

    over, beside = (core.rollout.course(np.array([-1.0, y, 0.0, -6e-3]), 0.0, turning, 1) for y in (1e-5, 1e-2))

    assert not over.is_safe
    assert beside.is_safe


def test_a_storage_function_does_not_jump_unseen() -> None:
    design = bearing_design(barriers=(), passivity=Passivity(V=4.0 + BEARING), mode="passive")
    core = SafetyPassivityFilter(design)

    assert core.decide(AWAY, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)).status is Status.MODIFIED
    assert core.decide(AT_CUT, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)).status.is_fallback


def test_a_check_tells_of_an_angle() -> None:
    core = SafetyPassivityFilter(bearing_design())

    found = [each for each in formula_findings(core.design, core.chains) if each.topic == "angle"]

    assert len(found) == 1
    assert "atan2(x_1,x_0) jumps by a full turn" in found[0].found


def test_dynamics_do_not_jump_unseen() -> None:
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    slip = ca.atan2(x[2], -1.0)  # π above x₂ = 0, −π below
    system = System(x=x, u=u, f=ca.vertcat(x[1], u + 3 * slip, -1.0), y=x[1])
    wall = Barrier(name="wall", h=1 + x[0], class_k=gains(4, 4, 4))
    design = bearing_design(
        system=system,
        fail_safe=0.0,
        barriers=[wall],
        passivity=Passivity(V=x[1] ** 2 / 2),
        input_bound=30.0,
        uncertainty=SLIPPING,
    )
    core, growth = SafetyPassivityFilter(replace(design, uncertainty=None)), ErrorGrowth(design)

    for ahead, is_known in ((0.5, True), (0.005, False)):
        decision = core.decide((-0.95, -0.1, ahead), (0.0,), (-30.0,), (0.0,))
        assert decision.status.is_fallback is not is_known
        assert np.isfinite(growth.advance((-0.95, -0.1, ahead), (0.0,), (0.0,) * 3)).all() == is_known
