"""The paper's printed rows (section 4) against ours: where they are right, and the errata of ``docs/theory.md``."""

import numpy as np
import pytest
from core_designs import gains, paper_design
from finite_differences import Array, numeric, rate_along
from numpy.random import Generator

from passafe.barrier_chain import Barrier
from passafe.barriers import disk_keep_out
from passafe.class_k import ClassK, Cubic
from passafe.design import Law
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity

SIGMA, D, K_P, K_D, K_I, DT_S = 1.3, 0.9, 4.0, 3.0, 20.0, 1e-3
GAIN_X, GAIN_U = 2.0, 7.0


def paper_filter() -> SafetyPassivityFilter:
    """Return the filter of the paper's section 4: σ, gains and d as above, γ₁ = γ₂ = s, γ_x = 2s³, γ_u = 7s."""
    robot = damped_point(sigma=SIGMA)
    disk = disk_keep_out(robot.position, centre=(0.0, 0.0), radius=D)
    class_k: tuple[ClassK, ...] = gains(1.0, 1.0, Cubic(gain=GAIN_X))
    x = robot.system.x
    return SafetyPassivityFilter(
        paper_design(
            system=robot.system,
            u_fb=robot.proportional_derivative(k_p=K_P, k_d=K_D),
            fail_safe=robot.fail_safe,
            barriers=(Barrier(name="disk", h=disk, class_k=class_k),),
            passivity=Passivity(V=x.T @ x, class_k=gains(GAIN_U)[0]),
            k_i=K_I,
            dt_s=DT_S,
            input_bound=1e5,
            law=Law.CONTINUOUS,
        )
    )


def psi_2(x1: Array, x2: Array, u: Array) -> float:
    """h_x″ of the paper, as printed."""
    return float(x1 @ x1 + 2 * x2 @ x2 + 2 * (2 - SIGMA) * x1 @ x2 + 2 * x1 @ u - D**2)


def h_u(x1: Array, x2: Array, u: Array) -> float:
    return float(2 * SIGMA * x2 @ x2 - 2 * x1 @ x2 - x2 @ u)


def b_x(x1: Array, x2: Array, u: Array, phi: Array) -> float:
    """Return the right-hand side of the safety row as printed, which is correct."""
    drift = (2 * x1 + 2 * (2 - SIGMA) * x2 + 2 * u) @ x2 + (4 * x2 + 2 * (2 - SIGMA) * x1) @ (-SIGMA * x2 + u)
    return float(drift + 2 * x1 @ phi + GAIN_X * psi_2(x1, x2, u) ** 3)


def b_u_printed(x1: Array, x2: Array, u: Array, phi: Array) -> float:
    drift = -(1 + 3 * SIGMA**2) * x2 @ x2 + 2 * SIGMA * x1 @ x2 - (2 * x1 - 3 * SIGMA * x2) @ u
    return float(drift - x2 @ phi + GAIN_U * h_u(x1, x2, u))


def b_u_corrected(x1: Array, x2: Array, u: Array, phi: Array) -> float:
    drift = -(2 + 4 * SIGMA**2) * x2 @ x2 + 2 * SIGMA * x1 @ x2 - (2 * x1 - 5 * SIGMA * x2) @ u - u @ u
    return float(drift - x2 @ phi + GAIN_U * h_u(x1, x2, u))


Given = tuple[Array, Array, Array, Array, Array]


def draw(rng: Generator) -> Given:
    """Random x₁, x₂, u, u_h, u̇_h."""
    x1, x2, u, u_h, u_h_rate = rng.uniform(-2, 2, (5, 2))
    return x1, x2, u, u_h, u_h_rate


def phi_of(given: Given) -> Array:
    """φ of the paper, as printed."""
    x1, x2, u, u_h, u_h_rate = given
    u_hat = -K_P * x1 - K_D * x2 + u_h
    return np.asarray(-K_P * x2 - K_D * (-SIGMA * x2 + u) + K_I * (u_hat - u) + u_h_rate)


def test_rows_are_the_corrected_closed_forms_of_the_paper() -> None:
    """A unit row G z ≥ d in z = dt·v is A v ≤ b with A = −G and b = −d/dt, up to a positive factor."""
    paper = paper_filter()
    rng = np.random.default_rng(10)
    assert paper.row_names[: paper.constraints] == ("disk", "passivity")
    for _ in range(300):
        given = draw(rng)
        x1, x2, u, u_h, u_h_rate = given
        phi = phi_of(given)
        decision = paper.decide([*x1, *x2], list(u), list(u_h), list(u_h_rate))
        G, d = decision.part("G").reshape(2, 2, order="F"), decision.part("d")
        lengths = np.array([np.hypot(*(2 * x1)), np.hypot(*x2)])
        A, b = -G * lengths[:, None], -d * lengths / DT_S

        assert decision.phi == pytest.approx(phi)
        assert A[0] == pytest.approx(-2 * x1)
        assert A[0] != pytest.approx(-x1)  # the printed A_x
        assert b[0] == pytest.approx(b_x(x1, x2, u, phi))
        assert A[1] == pytest.approx(x2)
        assert b[1] == pytest.approx(b_u_corrected(x1, x2, u, phi))
        assert b[1] != pytest.approx(b_u_printed(x1, x2, u, phi), rel=1e-3)


def test_finite_differences_side_with_the_corrected_forms() -> None:
    """d/dt ψ₂ + γ_x(ψ₂) = b_x − A_x v and d/dt h_u + γ_u(h_u) = b_u − A_u v, for the v with u̇ = φ + v."""
    rng = np.random.default_rng(11)
    for _ in range(100):
        given = draw(rng)
        x1, x2, u, *_ = given
        phi, v = phi_of(given), rng.uniform(-20, 20, 2)

        def extended(_: float, s: Array, rate: Array = phi + v) -> Array:
            return np.concatenate([s[2:4], -SIGMA * s[2:4] + s[4:], rate])

        def functions(s: Array) -> Array:
            return np.array([psi_2(s[:2], s[2:4], s[4:]), h_u(s[:2], s[2:4], s[4:])])

        start = np.concatenate([x1, x2, u])
        here = functions(start)
        rates = rate_along(functions, extended, start, 2e-4)
        safety, passivity = rates[0] + GAIN_X * here[0] ** 3, rates[1] + GAIN_U * here[1]

        assert b_x(x1, x2, u, phi) + 2 * x1 @ v == pytest.approx(safety, rel=1e-7, abs=1e-6)
        assert b_x(x1, x2, u, phi) + x1 @ v - safety == pytest.approx(-x1 @ v, rel=1e-3, abs=1e-3)  # printed A_x: off
        assert b_u_corrected(x1, x2, u, phi) - x2 @ v == pytest.approx(passivity, rel=1e-7, abs=1e-6)
        off = (1 + SIGMA**2) * x2 @ x2 - 2 * SIGMA * x2 @ u + u @ u
        assert b_u_printed(x1, x2, u, phi) - x2 @ v - passivity == pytest.approx(off, rel=1e-5, abs=1e-5)


def test_the_printed_rest_point_needs_a_unit_gain() -> None:
    """At rest −k_P x₁ + u_h = 0, so u_h = [−0.3, 0] rests at [−0.3, 0] only for k_P = 1."""
    for k_p, rest in ((1.0, -0.3), (10.0, -0.03)):
        robot = damped_point()
        feedback = numeric([robot.system.x], robot.proportional_derivative(k_p=k_p, k_d=5.0))

        assert feedback([rest, 0, 0, 0]) == pytest.approx([0.3, 0.0])
