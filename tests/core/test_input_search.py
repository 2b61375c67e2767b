"""The search of all admissible inputs where tangents of a row that is not affine in u conflict."""

import casadi as ca
import numpy as np
import pytest

import passafe.input_search
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
    monkeypatch.setattr(passafe.input_search, "BOXES", 1)

    assert lifted(6.0).status is Status.UNCERTIFIED


def test_nothing_is_claimed_where_the_input_found_leads_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """At u = 0 the tangent of u² is level: from there no answer is found, whatever the search says."""
    found = passafe.input_search.Found(u=np.zeros(1))
    monkeypatch.setattr(passafe.input_search.InputSearch, "find", lambda _search, _block: found)

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
