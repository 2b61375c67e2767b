"""The fail-safe under inputs that are held: it never overshoots, and stops as soon as its scope says."""

from collections.abc import Callable
from math import exp, inf

import casadi as ca
import numpy as np
import pytest
from finite_differences import Array, numeric, runge_kutta

from passafe.class_k import Cubic, Linear
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.held_braking import HeldBraking, longest_hold_s
from passafe.models.held_lagged_braking import HeldLaggedBraking, LaggedGains
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.models.saturating_point import saturating_point

ROBOTS: dict[str, Callable[..., Robot]] = {
    "damped": damped_point,
    "drag": lambda **given: drag_point(drag=3.0, **given),
    "saturating": lambda **given: saturating_point(force=4.0, **given),
}


def held_periods(robot: Robot, x: Array, dt_s: float, periods: int, fine: int = 20) -> Array:
    """Return the states on the way, at instants between samples too, one row each."""
    law = numeric([robot.system.x], robot.fail_safe)
    flow = numeric([robot.system.x, robot.system.u], robot.system.f)
    path = [x]
    for _ in range(periods):
        u = law(path[-1])
        for _ in range(fine):
            path.append(runge_kutta(lambda _, s, u=u: flow(s, u), 0.0, path[-1], dt_s / fine))
    return np.array(path)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("sigma", [0.05, 1.0, 30.0])
@pytest.mark.parametrize("gamma_1", [0.5, 8.0, 22.0, 400.0])
@pytest.mark.parametrize("dt_s", [0.001, 0.02, 0.1])
def test_no_held_fail_safe_overshoots_or_stops_late(name: str, sigma: float, gamma_1: float, dt_s: float) -> None:
    robot = ROBOTS[name](sigma=sigma, gamma_1=gamma_1, dt_s=dt_s)
    scope = robot.fail_safe_scope
    for speed in (min(0.3, scope.top_speed), min(20.0, scope.top_speed)):
        path = held_periods(robot, np.array([0.0, 0.0, 0.6 * speed, 0.8 * speed]), dt_s, 40)

        assert (path[:, 2:] @ [0.6, 0.8]).min() >= -1e-6 * speed
        assert np.linalg.norm(path[-1, :2]) <= speed / scope.kept_gains[0] * (1 + 1e-6)


def test_ten_hertz_and_a_gain_of_22_stand_after_one_period() -> None:
    robot = damped_point(sigma=1.0, gamma_1=22.0, dt_s=0.1)
    path = held_periods(robot, np.array([0.0, 0.0, 1.0, 0.0]), 0.1, 1)

    assert path[-1, 2] == pytest.approx(0.0, abs=1e-9)
    assert robot.fail_safe_gain == pytest.approx(1 / (exp(0.1) - 1))
    assert robot.fail_safe_scope.kept_gains[0] == pytest.approx(1 / path[-1, 0], rel=1e-6)
    assert not robot.fail_safe_scope.keeps((Linear(gain=22.0),))
    assert f"γ₁ ≤ {1 / path[-1, 0]:g}/s" in robot.fail_safe_condition


def test_a_gain_that_may_be_held_stays_as_it_is() -> None:
    robot = damped_point(sigma=1.0, gamma_1=10.0, dt_s=0.001)

    assert robot.fail_safe_gain == 9.0
    assert robot.fail_safe_scope.keeps((Linear(gain=10.0), Cubic(gain=900.0)))
    assert "each of its inputs held for at most 0.1054 s, (1 − e^(−σdt))(1 + K/σ) ≤ 1" in robot.fail_safe_condition
    assert longest_hold_s(1.0, 0.0) == inf


def test_only_linear_functions_are_kept() -> None:
    scope = FailSafeScope(kept_gains=(5.0, 7.0))

    assert scope.keeps((Linear(gain=5.0), Linear(gain=7.0), Linear(gain=99.0)))
    assert not scope.keeps((Linear(gain=5.1), Linear(gain=7.0)))
    assert not scope.keeps((Linear(gain=5.0), Cubic(gain=1.0)))


def test_least_gain_and_kept_gain_are_each_others_inverse() -> None:
    for z in (1e-6, 9.99e-4, 1.001e-3, 0.3, 4.0):
        held = HeldBraking(sigma=2.0, dt_s=z / 2)
        assert held.kept_gain(held.least_gain(7.0)) == pytest.approx(7.0, rel=1e-9)
        assert held.least_gain(1.0) == 0.0
        assert held.lag_s == pytest.approx(held.dt_s * (0.5 + z / 12), rel=z**3)


@pytest.mark.parametrize(
    ("sigma", "lag_s", "gamma_1", "gamma_2", "dt_s"),
    [
        (1.0, 0.05, 6.0, 6.0, 0.1),
        (1.0, 0.005, 5.0, 5.0, 0.002),
        (1.0, 1.0, 5.0, 9.0, 0.1),
        (0.5, 0.5, 4.0, 4.0, 0.05),
        (30.0, 0.05, 6.0, 6.0, 0.1),
        (0.05, 10.0, 0.2, 0.2, 0.001),
    ],
)
def test_a_held_lagged_fail_safe_keeps_walls(
    sigma: float, lag_s: float, gamma_1: float, gamma_2: float, dt_s: float
) -> None:
    robot = lagged_point(sigma=sigma, lag_s=lag_s, gamma_1=gamma_1, gamma_2=gamma_2, dt_s=dt_s)
    rng = np.random.default_rng(6)
    assert robot.fail_safe_scope.keeps((Linear(gain=gamma_1), Linear(gain=gamma_2)))
    for _ in range(12):
        h, psi_1, psi_2 = rng.exponential(size=3) * rng.integers(0, 2, 3)
        rate = psi_1 - gamma_1 * h
        force = psi_2 - (gamma_1 + gamma_2) * rate - gamma_1 * gamma_2 * h + sigma * rate
        path = held_periods(robot, np.array([h, 0.0, rate, 0.0, force, 0.0]), dt_s, 60)

        assert path[:, 0].min() >= -1e-6 * (1 + abs(force))


def test_a_lagged_fail_safe_that_keeps_nothing_says_so() -> None:
    robot = lagged_point(sigma=1.0, lag_s=0.5, gamma_1=50.0, gamma_2=50.0, dt_s=0.1)
    path = held_periods(robot, np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), 0.1, 40)

    assert not robot.fail_safe_scope.keeps((Linear(gain=0.1),))
    assert "none" in robot.fail_safe_condition
    assert path[-1, 2:] == pytest.approx(0.0, abs=1e-6)  # but it stops


def test_lagged_gains_that_diverge_or_never_rest_are_refused() -> None:
    braking = HeldLaggedBraking(sigma=1.0, lag_s=0.5, gamma_1=4.0, gamma_2=4.0, dt_s=0.1)

    assert not braking.keeps(LaggedGains(on_velocity=500.0, on_force=0.0))
    assert not braking.keeps(LaggedGains(on_velocity=-1.0 + 1e-9, on_force=0.0))


def test_a_drag_point_without_a_gain_coasts() -> None:
    assert ca.DM(drag_point(sigma=2.0, gamma_1=1.0, dt_s=0.1).fail_safe_gain) == 0.0
