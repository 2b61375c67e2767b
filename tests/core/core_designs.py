"""Designs on which the core is tested: the paper's, some nonlinear ones, and one whose rows are its state."""

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from passafe.answers.replaced_answer import BACKUP, BETWEEN, DEEPEST
from passafe.barrier_chain import Barrier
from passafe.barriers import disk_keep_out, half_plane
from passafe.class_k import ClassK, Cubic, Linear, Piecewise
from passafe.decision import Decision
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.passivity import Passivity
from passafe.system import System
from passafe.tank import Tank

PAPER_START = (2.0, 2.0, -1.0, -1.0)


def paper_design(**changes: object) -> FilterDesign:
    """Return the design of theory.md, section 3, with some parts changed."""
    robot = damped_point(sigma=1.0, gamma_1=10.0)
    disk = disk_keep_out(robot.position, centre=(0.0, 0.0), radius=1.0)
    parts: dict[str, object] = {
        "system": robot.system,
        "u_fb": robot.proportional_derivative(k_p=10.0, k_d=5.0),
        "fail_safe": robot.fail_safe,
        "barriers": (Barrier(name="disk", h=disk, class_k=gains(10.0, 10.0, Cubic(gain=100.0))),),
        "passivity": paper_passivity(robot.system.x),
        "k_i": 100.0,
        "dt_s": 1e-3,
        "input_bound": 100.0,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name


def paper_passivity(x: ca.SX, *, tank: Tank | None = None, slack_weight: float = 1e4) -> Passivity:
    """Return V = ‖x‖² with the class-K function and the slack's price of the reference scenario."""
    gamma_u = Piecewise(gain=100.0, gain_below=1000.0)
    return Passivity(V=ca.sumsqr(x), class_k=gamma_u, slack_weight=slack_weight, tank=tank)


def gains(*each: float | ClassK) -> tuple[ClassK, ...]:
    """Return class-K functions, linear where only a gain is given."""
    return tuple(one if isinstance(one, ClassK) else Linear(gain=one) for one in each)


def damped_design(**changes: object) -> FilterDesign:
    """Return the paper's design: linear, affine in u, relative degree 2."""
    return paper_design(**changes)


def drag_design(**changes: object) -> FilterDesign:
    """Return a nonlinear design with a disk off the origin, a half-plane and V that is not quadratic."""
    robot = drag_point(sigma=0.5, drag=0.7, gamma_1=3.0)
    disk = disk_keep_out(robot.position, centre=(0.3, -0.2), radius=0.5)
    wall = half_plane(robot.position, normal=(0.6, 0.8), offset=-4.0)
    energy = ca.sumsqr(robot.velocity) + 1 - ca.cos(robot.position[0]) + robot.position[1] ** 4 / 4
    parts: dict[str, object] = {
        "system": robot.system,
        "u_fb": -4 * ca.tanh(robot.position) - 2 * robot.velocity,
        "fail_safe": robot.fail_safe,
        "barriers": (
            Barrier(name="disk", h=disk, class_k=gains(3.0, 5.0, Piecewise(gain=4.0, gain_below=9.0))),
            Barrier(name="wall", h=wall, class_k=gains(2.0, Cubic(gain=0.5), 6.0)),
        ),
        "passivity": Passivity(V=energy, class_k=Cubic(gain=2.0), tank=Tank()),
        "k_i": 20.0,
        "dt_s": 2e-3,
        "input_bound": 50.0,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name


def jerk_design(**changes: object) -> FilterDesign:
    """Return a point whose acceleration is a state: one input, relative degree 3."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    position, velocity, acceleration = ca.vertsplit(x)
    f = ca.vertcat(velocity, acceleration - 0.2 * velocity**3, ca.sin(position) - acceleration + 2 * u)
    parts: dict[str, object] = {
        "system": System(x=x, u=u, f=f, y=velocity),
        "u_fb": -position - 2 * velocity - acceleration,
        "fail_safe": -acceleration,
        "barriers": (Barrier(name="stop", h=2 - position, class_k=gains(2.0, 3.0, Cubic(gain=1.0), 4.0)),),
        "passivity": Passivity(V=ca.sumsqr(x) / 2),
        "k_i": 10.0,
        "dt_s": 1e-2,
        "input_bound": 40.0,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name


def pump_design(**changes: object) -> FilterDesign:
    """Return a system that is not affine in u, with a barrier of relative degree 1."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    f = ca.vertcat(-x[0] + x[1] ** 2 + ca.sinh(u[0]), ca.sin(x[0]) + (2 + ca.cos(x[1])) * u[1] + u[0] * u[1])
    parts: dict[str, object] = {
        "system": System(x=x, u=u, f=f, y=ca.vertcat(x[0], x[1] ** 3)),
        "u_fb": ca.vertcat(-x[0] * x[1], -ca.sin(x[1])),
        "fail_safe": ca.SX.zeros(2),
        "barriers": (Barrier(name="level", h=3 - x[0] ** 2 - x[0] * x[1], class_k=gains(1.5, 2.5)),),
        "passivity": Passivity(V=x[0] ** 2 + ca.exp(x[1])),
        "k_i": 5.0,
        "dt_s": 5e-3,
        "input_bound": 4.0,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name


Builder = Callable[..., FilterDesign]
DESIGNS: tuple[Builder, ...] = (damped_design, drag_design, jerk_design, pump_design)


def row_filter(
    *, hard: int, soft: bool, slack_weight: float = 1e4, input_bound: float = 100.0
) -> SafetyPassivityFilter:
    """Return a filter whose rows gᵢᵀu⁺ + cᵢ (+ δ) ≥ 0 are read from its state, so that any QP can be put to it.

    The state is (position, time, g₁, c₁, g₂, c₂, g₃, c₃), of which the rows do not change: hᵢ = gᵢᵀ·position + cᵢ has
    relative degree 1 and ψ₁ = gᵢᵀu + cᵢ at position 0; y = g₃ and V = ½(time − c₃)² give h_u = g₃ᵀu + c₃ at time 0.

    Args:
        hard: How many of the first two rows are there.
        soft: Whether the third, the passivity row, is.
        slack_weight: Price of the soft row's slack.
        input_bound: Largest magnitude of each axis of u.
    """
    x, u = ca.SX.sym("x", 12), ca.SX.sym("u", 2)
    rows = [(x[3 + 3 * i : 5 + 3 * i], x[5 + 3 * i]) for i in range(3)]
    system = System(x=x, u=u, f=ca.vertcat(u, 1, ca.SX.zeros(9)), y=rows[2][0])
    barriers = tuple(
        Barrier(name=f"row {i}", h=ca.dot(rows[i][0], x[:2]) + rows[i][1], class_k=gains(1.0, 1.0)) for i in range(hard)
    )
    design = FilterDesign(
        system=system,
        u_fb=ca.SX.zeros(2),
        fail_safe=ca.SX.zeros(2),
        barriers=barriers,
        passivity=Passivity(V=(x[2] - rows[2][1]) ** 2 / 2, slack_weight=slack_weight),
        k_i=1.0,
        dt_s=1e-3,
        input_bound=input_bound,
        law=Law.SAMPLED,
        mode=Mode.BOTH if soft else Mode.SAFE,
        between_samples=False,
    )
    return SafetyPassivityFilter(design)


def row_state(rows: Sequence[Sequence[float]]) -> list[float]:
    """Return the state of ``row_filter`` that holds up to three rows (g₁, g₂, c)."""
    numbers = [float(value) for row in rows for value in row]
    return [0.0] * 3 + numbers + [0.0] * (9 - len(numbers))


def random_state(rng: np.random.Generator, size: int, scale: float = 1.5) -> NDArray[np.float64]:
    """Return a vector in general position."""
    return rng.uniform(-scale, scale, size)


def assert_consistent(made: SafetyPassivityFilter, decision: Decision) -> None:
    """Assert that every part of a decision is what its name says, whatever its status."""
    design = made.design
    N, m = len(made.row_names), design.system.m
    z = decision.part("z")
    constraints = decision.part("G").reshape((made.constraints, z.size), order="F")
    axes = np.eye(m, z.size)
    G = np.vstack((constraints, axes, -axes))
    low, high, u_ref = (decision.part(name) for name in ("low", "high", "u_ref"))
    d = np.concatenate((decision.part("d"), low - u_ref, u_ref - high))
    held = np.asarray(decision.u)

    assert held == pytest.approx(np.clip(u_ref + z[:m], low, high))
    assert decision.margins == pytest.approx(G @ z - d)
    assert decision.v == pytest.approx((held - decision.part("u")) / design.dt_s - decision.phi)
    assert np.linalg.norm(constraints, axis=1) == pytest.approx(np.ones(made.constraints))
    if decision.solver in {BACKUP, BETWEEN, DEEPEST}:
        assert decision.duals.tolist() == [0.0] * N
        return
    asked = d.copy()
    asked[: decision.part("relax").size] -= decision.part("relax")
    scale = 1 + np.linalg.norm(z)
    pull = G.T @ decision.duals
    violation = max((asked - G @ z).max(initial=0.0), 0.0)
    gap = abs(z @ z / 2 - decision.duals @ asked + pull @ pull / 2)
    assert violation / scale == pytest.approx(decision.primal_residual, abs=1e-12)
    assert np.abs(z - pull).max() / scale <= decision.dual_residual + 1e-12
    assert decision.duals.min(initial=0.0) >= -decision.dual_residual * scale - 1e-12
    assert gap / (1 + z @ z) == pytest.approx(decision.gap, abs=1e-12)
    assert max(decision.primal_residual, decision.dual_residual) <= design.tolerance.residual
    assert decision.gap <= design.tolerance.gap
