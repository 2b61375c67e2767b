"""Claims where rows for all members of a family cannot be kept about one input, and may be about another."""

import casadi as ca
import pytest
from cart_designs import X, cart
from core_designs import gains

from passafe.barrier_chain import Barrier
from passafe.decision import Decision, Status
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.parameter import Parameter
from passafe.passivity import Passivity
from passafe.system import System
from passafe.uncertainty import Uncertainty

GAINS = gains(3, 3, 3)


def pendulum(**changes: object) -> FilterDesign:
    """Return a pendulum between two stops, whose length, in which f is not affine, multiplies the input, too."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    length, mass = Parameter.of("length", 1.0), Parameter.of("mass", 1.0)
    torque = u / (mass.symbol * length.symbol**2)
    swing = ca.vertcat(x[1], torque - 9.81 / length.symbol * ca.sin(x[0]))
    parts: dict[str, object] = {
        "system": System(x=x, u=u, f=swing, y=x[1], parameters=(length, mass)),
        "barriers": [Barrier(name=name, h=h, class_k=GAINS) for name, h in (("a", 1 - x[0]), ("b", 1 + x[0]))],
        "passivity": Passivity(V=x[1] ** 2 / 2),
        "k_i": 25.0,
        "dt_s": 0.02,
        "input_bound": 40.0,
        "mode": "safe",
        "uncertainty": Uncertainty(parameters={"length": (0.8, 1.2), "mass": (0.8, 1.3)}, state_error=(1e-2, 3e-2)),
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types


def asked(core: SafetyPassivityFilter, x: tuple[float, ...], u: float, u_h: float) -> Decision:
    return core.decide(x, (u,), (u_h,), (0.0,))


@pytest.mark.parametrize("x", [(0.0, 0.0), (0.8, 0.0)])
@pytest.mark.parametrize("u_h", [0.0, 60.0])
def test_rows_that_some_input_keeps_are_kept_from_any_before(x: tuple[float, float], u_h: float) -> None:
    core = SafetyPassivityFilter(pendulum())

    found = {asked(core, x, u, u_h).status for u in (0.0, -10.0, 40.0)}

    assert asked(core, x, 0.0, 0.0).status is Status.PASSED  # so no input keeps all rows of all members
    assert found <= {Status.PASSED, Status.MODIFIED}


def test_what_no_member_in_the_middle_can_keep_is_impossible() -> None:
    core = SafetyPassivityFilter(pendulum(input_bound=1.0))

    assert asked(core, (0.5, 3.0), 0.0, 0.0).status is Status.INFEASIBLE


def test_what_members_alone_may_break_is_no_proof() -> None:
    core = SafetyPassivityFilter(
        cart(
            barriers=[Barrier(name=n, h=h, class_k=gains(2, 2, 2)) for n, h in (("a", 1 - X[0]), ("b", 1 + X[0]))],
            uncertainty=Uncertainty(disturbance=(0.0, 40.0)),
        )
    )

    decision = core.decide((0.0, 0.0), (0.0,), (0.0,), (0.0,))

    assert decision.status is Status.AT_SAMPLES
    assert abs(decision.u[0]) < 1e-3


@pytest.mark.parametrize(("sets", "status"), [(None, Status.BACKUP), (1e-4, Status.AT_SAMPLES)])
def test_a_course_of_the_model_proves_nothing_of_others(sets: float | None, status: Status) -> None:
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    lagged = System(x=x, u=u, f=ca.vertcat(x[1], x[2], (u - x[2]) / 0.01), y=x[1])
    core = SafetyPassivityFilter(
        FilterDesign(
            system=lagged,
            fail_safe=-4 * x[1],
            barriers=(Barrier(name="wall", h=1 - x[0], class_k=gains(2, 2, 2, 2)),),
            passivity=Passivity(V=x[1] ** 2 / 2),
            k_i=50.0,
            dt_s=0.01,
            hold_s=0.2,
            input_bound=20.0,
            mode="safe",  # type: ignore[arg-type]  # its value
            uncertainty=None if sets is None else Uncertainty(state_error=(sets,) * 3),
        )
    )

    assert core.decide((0.27, -0.04, 0.64), (0.0,), (20.0,), (0.0,)).status is status
