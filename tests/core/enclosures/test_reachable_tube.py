"""The tube of a held input: against closed forms of linear plants, and unknown near a finite escape time."""

import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric
from scipy.linalg import expm

from passafe.enclosures.reachable_tube import reachable_tube
from passafe.system import System

x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)


def tube(f: ca.SX, held_s: float, state: list[float], held: float) -> tuple[np.ndarray, float]:
    """Return radius and whether it is known, with the input known exactly."""
    size, known = reachable_tube(System(x=x, u=u, f=f, y=x[1]), held_s, ca.SX(0.0))
    given = numeric([x, u], ca.vertcat(size, known))(np.array(state), np.array([held]))
    return given[:-1], float(given[-1])


@pytest.mark.parametrize("held_s", [1e-3, 0.1, 2.0])
@pytest.mark.parametrize("A", [[[0, 1], [0, 0]], [[0, 1], [-4, -0.2]], [[-50, 0], [1, 0]], [[0.5, 1], [0, 0.5]]])
def test_linear_tubes_hold_their_trajectories(A: list[list[float]], held_s: float) -> None:
    """x(τ) − x(0) = ∫₀^τ e^{As}ds f, from one matrix exponential; a linear plant's tube closes for every T."""
    M = np.array(A, dtype=float)
    state, held = [0.7, -1.1], 1.3
    f = M @ state + np.array([0.0, held])
    radius, known = tube(ca.DM(M) @ x + ca.vertcat(0, u), held_s, state, held)
    block = np.block([[M, f[:, None]], [np.zeros((1, 3))]])

    assert known == 1
    for tau in np.linspace(0, held_s, 101):
        assert (np.abs(expm(block * tau)[:2, 2]) <= radius * (1 + 1e-9)).all()


def test_double_integrators_tube_is_nearly_tight() -> None:
    """|x₁(T) − x₁(0)| = T|v| + T²/2 |u| when v and u agree in sign: the tube is at most a few percent wider."""
    radius, _ = tube(ca.vertcat(x[1], u), 0.5, [0.0, 2.0], 3.0)

    assert 1.375 <= radius[0] <= 1.375 * 1.03
    assert radius[1] == pytest.approx(1.5)


@pytest.mark.parametrize(("held_s", "is_known"), [(0.1, True), (0.5, False), (0.6, False)])
def test_unknown_where_a_trajectory_escapes_within_the_hold(held_s: float, is_known: bool) -> None:
    """ẋ₁ = x₁² from 2 is 2/(1 − 2τ): it escapes at 0.5 s; before, the tube holds it."""
    radius, known = tube(ca.vertcat(x[0] ** 2, u), held_s, [2.0, 0.0], 0.0)

    assert known == float(is_known)
    if is_known:
        assert 2 / (1 - 2 * held_s) - 2 <= radius[0]
