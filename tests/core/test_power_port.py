"""A port is a pair: plants with other numbers of outputs than inputs, and of which part the power is supplied."""

import casadi as ca
import numpy as np
import pytest
from core_designs import gains
from scipy.integrate import solve_ivp

from passafe.barrier_chain import Barrier
from passafe.batch.batch_plant import BatchPlant
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.errors import DesignError, ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity, power_margin
from passafe.sampled_plant import SampledPlant
from passafe.system import System

X, U = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
ENERGY = (X[0] ** 2 + 2 * X[1] ** 2 + X[2] ** 2) / 2


def motor(*, drag: float = 0.0) -> System:
    """Return a mass that u₀ pushes, its position, and a state that u₁ sets; three outputs, a port of one pair."""
    f = ca.vertcat(-X[0] - drag * X[0] ** 3 + U[0] - X[1], X[0] / 2, -3 * X[2] + U[1])
    return System(x=X, u=U, f=f, y=ca.vertcat(X[0], X[1], X[2]), port_y=X[0], port_u=U[0])


def test_without_a_port_all_outputs_and_inputs_are_one() -> None:
    system = System(x=X, u=U, f=X, y=X[1:])

    assert ca.is_equal(system.power, ca.dot(X[1:], U), 3)
    assert (system.port_y.shape, system.port_u.shape) == ((2, 1), (2, 1))


def test_the_power_is_that_of_the_port() -> None:
    margin = ca.Function("margin", [X, U], [power_margin(motor(), ENERGY)])

    assert float(margin([2.0, 0.5, 1.0], [3.0, -4.0])) == pytest.approx(2 * 3 - (2 * (-2 + 3 - 0.5) + 0.5 * 2 - 3 - 4))


@pytest.mark.parametrize("drag", [0.0, 0.3])
def test_energy_is_what_the_port_supplies(drag: float) -> None:
    system = motor(drag=drag)
    plant, rate = SampledPlant(system, ENERGY, 0.2), ca.Function("rate", [X, U], [ca.vertcat(system.f, system.power)])
    x, u = (1.0, -0.4, 0.7), (2.5, -1.5)
    sample = plant.advance(x, u)
    exact = solve_ivp(lambda _, s: rate(s[:3], u).full().ravel(), (0, 0.2), [*x, 0.0], rtol=1e-12, atol=1e-13).y[:, -1]

    assert plant.exact is (drag == 0.0)
    assert sample.x == pytest.approx(exact[:3], rel=1e-9)
    assert sample.y == sample.x
    assert sample.energy_in_j == pytest.approx(exact[3], rel=1e-8)
    many = BatchPlant(plant, 2)
    many.advance(np.tile(np.array(x)[:, None], 2), np.tile(np.array(u)[:, None], 2))
    assert many.batch.part("energy")[0, :2] == pytest.approx([exact[3]] * 2, rel=1e-8)


def test_a_mixed_input_may_be_the_port_s() -> None:
    """Two thrusters, one body: the force is their sum."""
    p, thrust = ca.SX.sym("p", 2), ca.SX.sym("thrust", 2)
    body = System(x=p, u=thrust, f=[p[1], ca.sum1(thrust)], y=p[1], port_u=ca.sum1(thrust))  # type: ignore[arg-type]  # a list
    made = SafetyPassivityFilter(
        FilterDesign(
            system=body,
            barriers=(Barrier(name="wall", h=1 - p[0], class_k=gains(3.0, 3.0, 3.0)),),
            passivity=Passivity(V=p[1] ** 2 / 2),
            k_i=50.0,
            dt_s=1e-3,
            mode=Mode.BOTH,
            input_low=(0.0, -4.0),
            input_high=(6.0, 0.0),
        )
    )
    decision = made.decide((0.8, 0.5), (2.0, -1.0), (9.0, 0.0), (0.0, 0.0))

    assert decision.status is Status.MODIFIED
    assert decision.power_margin == pytest.approx(0.0, abs=1e-9)
    assert sum(decision.u) <= 9 * 0.2 - 6 * 0.5 + 1e-6


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"port_u": U}, r"system port_y: got shape \(3, 1\), allowed shape \(2, 1\)"),
        ({"port_y": X}, r"system port_y: got shape \(3, 1\), allowed shape \(2, 1\)"),
        ({"port_u": U.T}, r"system port_u: got shape \(1, 2\), allowed shape \(2, 1\)"),
        ({"port_u": X[0], "port_y": X[0]}, "system port_u: got the symbols"),
        ({"port_u": U[0], "port_y": U[0]}, "system port_y: got the symbols"),
        ({"port_u": U[0], "port_y": "speed"}, "system port_y: got 'speed'"),
        ({"y": ca.SX(0, 1), "port_u": U[0]}, r"system y: got shape \(0, 1\)"),
        ({"port_u": ca.SX(0, 1)}, r"system port_u: got shape \(0, 1\)"),
        ({}, r"system y: got shape \(3, 1\), allowed shape \(2, 1\)"),
    ],
)
def test_a_port_is_a_pair(parts: dict[str, ca.SX], message: str) -> None:
    with pytest.raises((ShapeError, DesignError), match=message):
        System(**({"x": X, "u": U, "f": X, "y": X} | parts))
