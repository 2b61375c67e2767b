from dataclasses import replace
from math import inf, nan

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, random_state
from finite_differences import Array, numeric, rate_along

from passafe.class_k import Linear
from passafe.errors import DesignError, ShapeError
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity, power_margin
from passafe.tank import Tank

V = ca.sumsqr(ca.SX.sym("x", 2))


@pytest.mark.parametrize("build", DESIGNS)
def test_power_margin_is_supplied_power_minus_storage_rate(build: Builder) -> None:
    design = build()
    system = design.system
    rng = np.random.default_rng(4)
    flow = numeric([system.x, system.u], system.f)
    output = numeric([system.x], system.y)
    storage = numeric([system.x], design.passivity.V)
    margin = numeric([system.x, system.u], power_margin(system, design.passivity.V))
    for _ in range(50):
        x, u = random_state(rng, system.n), random_state(rng, system.m)

        def rate(_: float, s: Array, u: Array = u) -> Array:
            return flow(s, u)

        assert margin(x, u) == pytest.approx(output(x) @ u - rate_along(storage, rate, x), rel=1e-7, abs=1e-7)


def test_power_margin_of_the_paper_in_closed_form() -> None:
    """h_u = 2σ‖x₂‖² − 2x₁ᵀx₂ − x₂ᵀu for V = ‖x‖² (paper, within equation 27)."""
    robot = damped_point(sigma=1.7)
    margin = numeric([robot.system.x, robot.system.u], power_margin(robot.system, ca.sumsqr(robot.system.x)))
    rng = np.random.default_rng(5)
    for _ in range(50):
        x, u = random_state(rng, 4), random_state(rng, 2)
        x1, x2 = x[:2], x[2:]

        assert margin(x, u) == pytest.approx(2 * 1.7 * x2 @ x2 - 2 * x1 @ x2 - x2 @ u)


def test_kinetic_energy_leaves_the_dissipation() -> None:
    robot = damped_point(sigma=2.0)
    kinetic = ca.sumsqr(robot.velocity) / 2
    margin = numeric([robot.system.x, robot.system.u], power_margin(robot.system, kinetic))

    assert margin([7, 8, 3, 4], [5, 6]) == pytest.approx(2.0 * 25)


def test_a_storage_is_a_scalar_function_of_the_state() -> None:
    robot = damped_point()

    with pytest.raises(ShapeError, match=r"storage V: got shape \(2, 1\), allowed shape \(1, 1\)"):
        power_margin(robot.system, robot.position)
    with pytest.raises(DesignError, match=r"storage V: got the symbols \['u_0'\]"):
        power_margin(robot.system, robot.system.u[0])


def test_defaults() -> None:
    passivity = Passivity(V=V)

    assert passivity.tank is None
    assert passivity.class_k == Linear(gain=100.0)
    assert (passivity.slack_weight, passivity.relaxed_above) == (1e6, 1e-3)
    assert Passivity(V=V, tank=Tank()).tank == Tank()


@pytest.mark.parametrize("field", ["slack_weight", "relaxed_above"])
@pytest.mark.parametrize("value", [0.0, -1.0, inf, nan])
def test_weights_are_positive_and_finite(field: str, value: float) -> None:
    with pytest.raises(DesignError) as refused:
        replace(Passivity(V=V), **{field: value})  # type: ignore[arg-type]  # either field is a number

    assert str(refused.value) == f"passivity {field}: got {value}, allowed a positive finite number"
