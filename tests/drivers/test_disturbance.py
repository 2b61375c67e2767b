"""Disturbances: of full size, by seed and time alone, against the barrier that is nearest to be lost."""

import casadi as ca
import pytest
from passafe_services.drivers.disturbance import Greedy, sine, switching

from passafe.barrier_chain import Barrier
from passafe.class_k import Linear
from passafe.system import System

X = (0.0, 0.0)


def test_switching_keeps_its_size_and_its_times() -> None:
    one, same = switching((2.0, 0.0), 0.5, seed=3), switching((2.0, 0.0), 0.5, seed=3)
    times = [k * 0.1 for k in range(200)]

    drawn = [one(t, X) for t in times]

    assert {abs(w[0]) for w in drawn} == {2.0}
    assert {w[1] for w in drawn} == {0.0}
    assert len({w[0] for w in drawn}) == 2
    assert drawn == [same(t, X) for t in reversed(times)][::-1]
    assert all(drawn[k] == drawn[k + 4] for k in range(0, 195, 5))  # within 0.5 s


def test_sine_swings_a_quarter_of_a_period_apart() -> None:
    w = sine((1.0, 3.0), 2.0)

    assert w(0.5, X) == pytest.approx((1.0, 0.0))
    assert w(1.0, X) == pytest.approx((0.0, 3.0))


def test_greedy_pushes_at_the_nearest_barrier() -> None:
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1])
    gains = (Linear(gain=2.0),) * 3
    walls = (Barrier(name="right", h=1 - x[0], class_k=gains), Barrier(name="left", h=1 + x[0], class_k=gains))
    greedy = Greedy((0.0, 0.5), system, walls)

    assert greedy(0.0, (0.5, 0.0)) == (0.0, 0.5)
    assert greedy(0.0, (-0.5, 0.0)) == (0.0, -0.5)
    assert greedy(0.0, (-0.5, 2.0)) == (0.0, 0.5)  # ψ₁ = ḣ + 2h of the right wall is the lower one
