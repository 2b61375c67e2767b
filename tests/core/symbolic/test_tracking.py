from collections.abc import Callable
from math import exp

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, PAPER_START, Builder, paper_design, random_state
from finite_differences import Array, numeric, rate_along
from scipy.integrate import solve_ivp

from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.symbolic.tracking import nominal_input, tracking_rate
from passafe.system import System

K_I = 40.0
Pair = tuple[float, float]


def phi_of(design: FilterDesign, k_i: float = K_I) -> tuple[Callable[..., Array], Callable[..., Array]]:
    """Functions (x, u, u_h, u_h_rate) → û and → φ."""
    system = design.system
    u_h, u_h_rate = ca.SX.sym("u_h", system.m), ca.SX.sym("u_h_rate", system.m)
    given = [system.x, system.u, u_h, u_h_rate]
    phi = tracking_rate(system, design.u_fb, u_h, u_h_rate, k_i)
    return numeric(given, nominal_input(design.u_fb, u_h)), numeric(given, phi)


@pytest.mark.parametrize("build", DESIGNS)
def test_phi_is_nominal_rate_plus_pull_towards_nominal(build: Builder) -> None:
    design = build()
    system = design.system
    n, m = system.n, system.m
    rng = np.random.default_rng(3)
    feedback = numeric([system.x], design.u_fb)
    flow = numeric([system.x, system.u], system.f)
    nominal, phi = phi_of(design)
    for _ in range(20):
        x, u, u_h, u_h_rate = (random_state(rng, size) for size in (n, m, m, m))

        def rate(_: float, s: Array, u: Array = u, u_h_rate: Array = u_h_rate) -> Array:
            return np.concatenate([flow(s[:n], u), u_h_rate])

        def u_hat(s: Array) -> Array:
            return feedback(s[:n]) + s[n:]

        start = np.concatenate([x, u_h])
        expected = rate_along(u_hat, rate, start) + K_I * (u_hat(start) - u)

        assert nominal(x, u, u_h, u_h_rate) == pytest.approx(u_hat(start))
        assert phi(x, u, u_h, u_h_rate) == pytest.approx(expected, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize("build", DESIGNS)
def test_squared_error_decays_at_twice_k_i_in_continuous_time(build: Builder) -> None:
    design = build()
    system = design.system
    n, m = system.n, system.m
    flow = numeric([system.x, system.u], system.f)
    nominal, phi = phi_of(design)
    u_h = np.linspace(0.5, -0.5, m)

    def operator(t: float) -> tuple[Array, Array]:
        return u_h * np.cos(3 * t), -3 * u_h * np.sin(3 * t)

    def extended(t: float, s: Array) -> Array:
        x, u = s[:n], s[n:]
        return np.concatenate([flow(x, u), phi(x, u, *operator(t))])

    def error(t: float, s: Array) -> float:
        return float(np.sum((s[n:] - nominal(s[:n], s[n:], *operator(t))) ** 2)) / 2

    start = np.concatenate([np.full(n, 0.3), np.full(m, 0.8)])
    duration = 0.1
    end = solve_ivp(extended, (0, duration), start, rtol=1e-10, atol=1e-12).y[:, -1]

    assert error(duration, end) == pytest.approx(exp(-2 * K_I * duration) * error(0, start), rel=1e-6)


def stepped_error(dt_s: float, u: Pair, u_h: Pair, u_h_rate: Pair, *, k_i: float) -> tuple[Array, Array]:
    """U − û before and after one period of the filter with v = 0 and the exact plant."""
    design = paper_design(mode=Mode.OFF, dt_s=dt_s, k_i=k_i)
    plant = SampledPlant(design.system, design.passivity.V, dt_s)
    before = SafetyPassivityFilter(design).decide(PAPER_START, u, u_h, u_h_rate)
    after = plant.advance(PAPER_START, u).x
    feedback = numeric([design.system.x], design.u_fb)
    u_hat_after = feedback(after) + np.asarray(u_h) + dt_s * np.asarray(u_h_rate)
    return np.asarray(u) - before.u_nominal, before.u - u_hat_after


def test_error_shrinks_by_1_minus_k_i_dt_in_one_period() -> None:
    """u⁺ − û⁺ = (1 − k_i·dt)(u − û) − ½dt²·d²û/dt² + O(dt³), here with d²û/dt² in closed form."""
    u, u_h, u_h_rate = (3.0, -2.0), (0.5, 1.0), (2.0, -4.0)
    x2 = np.array(PAPER_START[2:])
    acceleration = -x2 + u
    bend = -10.0 * acceleration - 5.0 * -acceleration  # û = −10x₁ − 5x₂ + u_h, and u̇ = 0 within a period
    left = {}
    for dt_s in (1e-3, 5e-4):
        before, after = stepped_error(dt_s, u, u_h, u_h_rate, k_i=K_I)
        left[dt_s] = after - (1 - K_I * dt_s) * before

    assert left[5e-4] == pytest.approx(-(5e-4**2) / 2 * bend, rel=1e-2)
    assert left[1e-3] / left[5e-4] == pytest.approx([4.0, 4.0], rel=1e-2)


def test_without_feedback_the_squared_error_shrinks_exactly() -> None:
    """With û̈ = 0, W⁺ = (1 − k_i·dt)²W holds exactly."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], u - x[0] ** 3), y=x[1])
    nothing = ca.SX(0.0)
    design = FilterDesign(
        system=system,
        u_fb=nothing,
        fail_safe=nothing,
        barriers=(),
        passivity=Passivity(V=ca.sumsqr(x)),
        k_i=K_I,
        dt_s=1e-2,
        input_bound=1e3,
        mode=Mode.OFF,
    )
    decided = SafetyPassivityFilter(design).decide((1.0, 2.0), (5.0,), (-1.0,), (3.0,))
    W = (5.0 - -1.0) ** 2 / 2
    W_next = (decided.u[0] - (-1.0 + 1e-2 * 3.0)) ** 2 / 2

    assert W_next == pytest.approx((1 - K_I * 1e-2) ** 2 * W, rel=1e-12)
