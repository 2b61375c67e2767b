"""The filter passes what is far from every wall, however stiff the robot's friction is."""

import casadi as ca
import pytest

from passafe.barrier_chain import Barrier
from passafe.class_k import Linear
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System


@pytest.mark.parametrize("sigma_hz", [37.0, 64.0, 140.0, 290.0])
def test_stiff_point_at_rest_is_left_alone(sigma_hz: float) -> None:
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    system = System(x=x, u=u, f=ca.vertcat(x[2:], u - sigma_hz * x[2:]), y=x[2:])
    gains = tuple(Linear(gain=4.0) for _ in range(3))
    design = FilterDesign(
        system=system,
        u_fb=ca.SX.zeros(2),
        fail_safe=ca.SX.zeros(2),
        barriers=(Barrier(name="wall", h=1.5 - x[0], class_k=gains),),
        passivity=Passivity(V=ca.sumsqr(x)),
        k_i=50.0,
        dt_s=3e-3,
        hold_s=0.012,
        input_bound=150.0,
        mode=Mode.SAFE,
    )
    decision = SafetyPassivityFilter(design).decide((0.0,) * 4, (0.0,) * 2, (2.0, 0.0), (0.0,) * 2)
    assert decision.status is Status.PASSED
    # The input follows the command through u̇ = k_i (u_h - u): one step of 3 ms from rest.
    assert decision.u == pytest.approx((3e-3 * 50.0 * 2.0, 0.0))
