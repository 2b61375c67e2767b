import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, random_state
from finite_differences import numeric, rate_along

from passafe.errors import DesignError, ShapeError
from passafe.models.damped_point import damped_point
from passafe.system import System

x = ca.SX.sym("x", 2)
u = ca.SX.sym("u")
f = ca.vertcat(x[1], u)


def test_counts_states_and_inputs() -> None:
    system = System(x=x, u=u, f=f, y=x[1])

    assert (system.n, system.m) == (2, 1)


@pytest.mark.parametrize("build", DESIGNS)
def test_lie_derivative_is_the_rate_along_the_flow(build: Builder) -> None:
    system = build().system
    rng = np.random.default_rng(1)
    expression = ca.vertcat(ca.sumsqr(system.x), ca.sin(system.x[0]) * system.x[-1])
    value = numeric([system.x], expression)
    rate = numeric([system.x, system.u], system.f)
    derived = numeric([system.x, system.u], system.lie_derivative(expression))
    for _ in range(20):
        state, held = random_state(rng, system.n), random_state(rng, system.m)

        measured = rate_along(value, lambda _, s, held=held: rate(s, held), state)  # type: ignore[misc]  # bound now

        assert derived(state, held) == pytest.approx(measured, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize(
    ("part", "symbol"),
    [
        ("x", ca.SX(3.0)),
        ("x", ca.SX.sym("x", 1, 2)),
        ("x", ca.SX.sym("x", 0)),
        ("x", 2 * x),
        ("u", ca.SX.sym("u", 0)),
        ("u", u + 1),
    ],
)
def test_states_and_inputs_are_columns_of_symbols(part: str, symbol: ca.SX) -> None:
    parts = {"x": x, "u": u, "f": f, "y": x[1]} | {part: symbol}

    with pytest.raises(ShapeError) as refused:
        System(**parts)

    assert (refused.value.field, refused.value.allowed) == (f"system {part}", "a non-empty column of symbols")


@pytest.mark.parametrize(
    ("part", "expression", "message"),
    [
        ("f", x[1], "system f: got shape (1, 1), allowed shape (2, 1)"),
        ("f", f.T, "system f: got shape (1, 2), allowed shape (2, 1)"),
        ("y", x, "system y: got shape (2, 1), allowed shape (1, 1)"),
    ],
)
def test_dynamics_and_output_have_their_shapes(part: str, expression: ca.SX, message: str) -> None:
    with pytest.raises(ShapeError) as refused:
        System(**({"x": x, "u": u, "f": f, "y": x[1]} | {part: expression}))

    assert str(refused.value) == message


@pytest.mark.parametrize("t", [ca.SX(0), ca.SX.sym("t", 2)])
def test_time_is_one_symbol(t: ca.SX) -> None:
    with pytest.raises(ShapeError, match=r"system t: got .* allowed one symbol"):
        System(x=x, u=u, f=f, y=x[1], t=t)


def test_foreign_symbols_are_named() -> None:
    with pytest.raises(DesignError) as in_f:
        System(x=x, u=u, f=f + ca.SX.sym("wind"), y=x[1])
    with pytest.raises(DesignError) as in_y:
        System(x=x, u=u, f=f, y=x[1] + u)

    assert str(in_f.value) == "system f: got the symbols ['wind'], allowed expressions of ['u', 'x_0', 'x_1']"
    assert str(in_y.value) == "system y: got the symbols ['u'], allowed expressions of ['x_0', 'x_1']"


def test_a_state_function_is_judged_by_name_shape_and_symbols() -> None:
    system = System(x=x, u=u, f=f, y=x[1])

    system.require_state_function("V", ca.sumsqr(x), 1)
    system.require_state_function("constant", ca.SX.zeros(2), 2)
    with pytest.raises(ShapeError, match="V: got shape"):
        system.require_state_function("V", x, 1)
    with pytest.raises(DesignError, match=r"V: got the symbols \['u'\]"):
        system.require_state_function("V", x[0] * u, 1)


def test_symbols_of_another_system_are_foreign_despite_names() -> None:
    one, other = damped_point(), damped_point()

    with pytest.raises(DesignError, match="storage V"):
        one.system.require_state_function("storage V", ca.sumsqr(other.system.x), 1)
