"""The search of all admissible inputs where tangents of a row that is not affine in u conflict."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import passafe.answers.input_search
from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.barrier_chain import Barrier
from passafe.class_k import Linear
from passafe.decision import Decision, Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System


def lifted(bound: float) -> Decision:
    """Return the answer for ẍ = u² − 9.81 at rest on the floor x = 0, with u = 0 before: u² ≥ 9.81 is asked for."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[1], u**2 - 9.81), y=x[1]),
        u_fb=ca.SX(0),
        fail_safe=ca.SX(bound),
        barriers=(Barrier(name="floor", h=x[0], class_k=(Linear(gain=3.0),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=1.0,
        dt_s=2e-3,
        input_bound=bound,
        mode=Mode.SAFE,
        between_samples=False,
    )
    return SafetyPassivityFilter(design).decide((0.0, 0.0), (0.0,), (0.0,), (0.0,), start=True)


def test_bound_that_lifts_is_found() -> None:
    decision = lifted(6.0)

    assert decision.status is Status.MODIFIED
    assert decision.u[0] ** 2 >= 9.81


@pytest.mark.parametrize("bound", [1.0, 3.1])
def test_bound_that_cannot_lift_is_proven_impossible(bound: float) -> None:
    assert lifted(bound).status is Status.INFEASIBLE


def test_nothing_is_claimed_where_boxes_run_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe.answers.input_search, "BOXES", 1)

    assert lifted(6.0).status is Status.UNCERTIFIED


def test_nothing_is_claimed_where_the_input_found_leads_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """At u = 0 the tangent of u² is level: from there no answer is found, whatever the search says."""
    found = passafe.answers.input_search.Found(u=np.zeros(1))
    monkeypatch.setattr(passafe.answers.input_search.InputSearch, "find", lambda _search, _block: found)

    assert lifted(6.0).status is Status.UNCERTIFIED


@pytest.mark.parametrize(("norm", "status"), [(5.0, Status.MODIFIED), (3.0, Status.INFEASIBLE)])
def test_corners_beyond_the_norm_are_not_admissible(norm: float, status: Status) -> None:
    """ẍ = u₁u₂ − 9.81 needs ‖u‖² ≥ 2·9.81: the box of ±6 would do, the disc of 3 in it does not."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[1], u[0] * u[1] - 9.81), y=ca.vertcat(x[1], x[1])),
        u_fb=ca.SX.zeros(2),
        fail_safe=ca.SX.zeros(2),
        barriers=(Barrier(name="floor", h=x[0], class_k=(Linear(gain=3.0),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=1.0,
        dt_s=2e-3,
        input_bound=6.0,
        input_norm_bound=norm,
        mode=Mode.SAFE,
        between_samples=False,
    )
    decision = SafetyPassivityFilter(design).decide((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), start=True)

    assert decision.status is status
    assert np.linalg.norm(decision.u) <= norm + 1e-9


def bump(before: float) -> Decision:
    """Return the answer for ẍ = 10·exp(−40(u − 4.3)²) − 9 half a metre above the floor: 4.3 ± 0.1 keeps it."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    return SafetyPassivityFilter(over_floor(ca.vertcat(x[1], 10 * ca.exp(-40 * (u - 4.3) ** 2) - 9), x, u)).decide(
        (0.5, -0.5), (before,), (before,), (0.0,)
    )


def over_floor(f: ca.SX, x: ca.SX, u: ca.SX) -> FilterDesign:
    return FilterDesign(
        system=System(x=x, u=u, f=f, y=ca.repmat(x[1], u.numel())),
        barriers=(Barrier(name="floor", h=x[0], class_k=(Linear(gain=2.0),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=10.0,
        dt_s=0.01,
        input_bound=6.0,
        mode=Mode.SAFE,
    )


@pytest.mark.parametrize("before", [0.0, 5.9, -6.0, 3.0, 4.3])
def test_level_tangents_at_the_best_input_hide_no_answer(before: float) -> None:
    decision = bump(before)

    assert decision.status in {Status.PASSED, Status.MODIFIED}
    assert decision.u[0] == pytest.approx(4.3, abs=0.1)


def test_an_input_that_just_keeps_a_row_is_not_the_only_one() -> None:
    """ẍ = |u| − 2 asks for |u| ≥ 0 here: at u = 0, where that has its kink, there is no room for a margin."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    made = SafetyPassivityFilter(over_floor(ca.vertcat(x[1], ca.fmax(u - 2, -u - 2)), x, u))

    assert made.decide((0.5, 0.0), (0.0,), (0.0,), (0.0,)).status is Status.MODIFIED


@pytest.mark.parametrize(("norm_bound", "status"), [(5.0, Status.MODIFIED), (3.0, Status.INFEASIBLE)])
def test_boxes_beyond_a_part_s_norm_are_left_out(norm_bound: float, status: Status) -> None:
    """As above, with a third axis that is no part of the norm."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 3)
    design = replace(
        over_floor(ca.vertcat(x[1], u[0] * u[1] - 9.81), x, u),
        input_norms=[NormBound(axes=(0, 1), bound=norm_bound)],
        between_samples=False,
    )
    answer = SafetyPassivityFilter(design).decide((0.0, 0.0), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, start=True)

    assert answer.status is status


@pytest.mark.parametrize(("most", "status"), [(7.0, Status.MODIFIED), (6.0, Status.INFEASIBLE)])
def test_boxes_beyond_a_half_space_are_left_out(most: float, status: Status) -> None:
    """u₁u₂ ≥ 9.81 asks for u₁ + u₂ ≥ 6.26, or both as far below zero, which another half-space forbids."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    sums = [HalfSpace(weights=(1.0, 1.0), bound=most), HalfSpace(weights=(-1.0, -1.0), bound=1.0)]
    design = replace(
        over_floor(ca.vertcat(x[1], u[0] * u[1] - 9.81), x, u), input_half_spaces=sums, between_samples=False
    )
    answer = SafetyPassivityFilter(design).decide((0.0, 0.0), (0.0,) * 2, (0.0,) * 2, (0.0,) * 2, start=True)

    assert answer.status is status
