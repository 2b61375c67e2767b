"""Jumps and what they add to the change of an expression: nothing out of reach, never too little within."""

import casadi as ca
import numpy as np
import pytest

from passafe.enclosure import enclose
from passafe.jump_bound import jump_bound

x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
BROKEN = {
    "slope of a magnitude": ca.gradient(ca.fabs(x[0]) * 3 + x[1] * x[0], x)[0] * (2 + u),
    "slope of an extreme": ca.gradient(ca.fmin(2 * x[0], x[1] + 1) + ca.sin(x[1]), x)[0],
    "two slopes": ca.gradient(ca.fmax(ca.fabs(x[0]), 0.5) * x[1], x)[0] + u * ca.sign(x[1]),
    "pieces": ca.if_else(x[0] > 0.2, 1 + x[1], u),
    "logic": ca.if_else(ca.logic_and(x[0] > 0, ca.logic_or(x[1] > 0, x[1] < x[0] - 1)), 2 * x[0] + 1, u),
}


@pytest.mark.parametrize("name", BROKEN)
def test_mean_value_and_jumps_bound_the_change(name: str) -> None:
    e, reach, held = BROKEN[name], ca.SX.sym("reach", 2), ca.SX.sym("held")
    size, known = jump_bound(e, x, reach, u, held)
    ball = enclose(ca.gradient(e, x), ca.vertcat(x, u), ca.vertcat(reach, held))
    steady = ca.dot(ca.fabs(ball.centre) + ball.radius, reach)
    bound = ca.Function("bound", [x, u, reach, held], [steady, size, known])
    value = ca.Function("value", [x, u], [e])
    rng, added = np.random.default_rng(21), 0
    for _ in range(120):
        at, push, away = rng.uniform(-1, 1, 2), rng.uniform(-1, 1), 10 ** rng.uniform(-3, -0.5, 2)
        continuous, jumps, sure = (float(part) for part in bound(at, push, away, 0.1))
        added += jumps > 0
        assert sure == 1.0
        for shift, other in zip(rng.uniform(-1, 1, (30, 2)), rng.uniform(-0.1, 0.1, 30), strict=True):
            change = float(value(at + shift * away, push + other)) - float(value(at, push + other))
            assert abs(change) <= continuous + jumps + 1e-12
    assert 2 < added < 115


@pytest.mark.parametrize(
    "e", [x[0] * u, ca.gradient(x[0] * ca.fabs(x[0]), x)[0], ca.fabs(x[0]) * x[1], ca.fmin(u, 5) * ca.sign(u)]
)
def test_a_continuous_expression_has_no_jumps(e: ca.SX) -> None:
    size, known = jump_bound(e, x, ca.SX([1, 1]), u, ca.SX(1))

    assert size.is_zero()
    assert known.is_one()
