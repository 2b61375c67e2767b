"""Jumps and what they add to the change of an expression: nothing out of reach, never too little within."""

import casadi as ca
import numpy as np
import pytest

from passafe.barrier_chain import Barrier, derive_chain
from passafe.enclosures.enclosure import enclose
from passafe.enclosures.jump_bound import jump_bound
from passafe.enclosures.reachable_tube import reachable_tube
from passafe.margins.intersample_margin import held_row
from passafe.system import System

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


def test_a_kink_of_the_dynamics_is_in_the_margin() -> None:
    """At rest under a push v changes its sign at once, and b with it, by twice the slope of |v| times the push."""
    z, push = ca.SX.sym("z", 2), ca.SX.sym("push")
    system = System(x=z, u=push, f=ca.vertcat(z[1], push - 2 * ca.fabs(z[1])), y=z[1])
    wall = Barrier(name="wall", h=1 - z[0], class_k=(3.0, 3.0, 3.0))
    held_s = 0.01
    row = held_row(system, derive_chain(system, wall), held_s)
    deviation = row.deviation(system, reachable_tube(system, held_s, ca.SX(0)), held_s, ca.SX(0))
    seen = ca.Function("seen", [z, push], [row.bend, deviation.size, deviation.known])
    flow = ca.Function("flow", [z, push], [system.f])
    for speed, held in ((-1e-3, 4.0), (1e-3, -4.0), (0.0, 2.0), (0.5, -1.0)):
        start = at = np.array([0.0, speed])
        before, size, known = (float(part) for part in seen(start, held))
        change = 0.0
        for _ in range(100):
            at = at + held_s / 100 * flow(at, held).full().ravel()
            change = max(change, abs(float(seen(at, held)[0]) - before))
        assert known == 1.0
        assert change <= size + 1e-12
        assert (size > abs(held) * held_s) == (speed < 0.1)
