"""The shipped robots: their dynamics, refusals, and the fail-safe's condition (``docs/theory.md``, section 6)."""

from collections.abc import Callable
from math import exp, inf, nan

import casadi as ca
import numpy as np
import pytest
from finite_differences import Array, numeric

from passafe.errors import DesignError
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.joint_chain import joint_chain
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.models.saturating_point import saturating_point
from passafe.models.two_points import two_points
from passafe.sampled_plant import SampledPlant

DT_S = 5e-3
TOP_SPEED = 50.0
BUILDERS: dict[str, Callable[[float], Robot]] = {
    "damped point": lambda gamma_1: damped_point(sigma=1.0, gamma_1=gamma_1),
    "drag point": lambda gamma_1: drag_point(sigma=1.0, drag=0.5, gamma_1=gamma_1),
}


def dynamics(robot: Robot, x: list[float], u: list[float]) -> Array:
    return numeric([robot.system.x, robot.system.u], robot.system.f)(x, u)


def test_damped_point_is_the_papers_robot() -> None:
    robot = damped_point(sigma=2.0)

    assert dynamics(robot, [1, 2, 3, 4], [5, 6]).tolist() == [3, 4, -2 * 3 + 5, -2 * 4 + 6]
    parts = numeric([robot.system.x], ca.vertcat(robot.position, robot.velocity, robot.system.y))
    assert parts([1, 2, 3, 4]).tolist() == [1, 2, 3, 4, 3, 4]


def test_drag_point_slows_with_the_square_of_its_speed() -> None:
    robot = drag_point(sigma=2.0, drag=0.1)

    # ‖x₂‖ = 5: −(2 + 0.1·5)x₂ + u
    assert dynamics(robot, [1, 2, 3, 4], [5, 6]) == pytest.approx([3, 4, -2.5 * 3 + 5, -2.5 * 4 + 6])
    assert dynamics(robot, [1, 2, 0, 0], [5, 6]).tolist() == [0, 0, 5, 6]
    slope = numeric([robot.system.x, robot.system.u], ca.jacobian(robot.system.f, robot.system.x))
    assert np.isfinite(slope([0, 0, 0, 0], [0, 0])).all()


def test_without_quadratic_drag_it_is_the_damped_point() -> None:
    one, other = damped_point(sigma=0.7), drag_point(sigma=0.7, drag=0.0)

    assert dynamics(one, [1, 2, 3, 4], [5, 6]) == pytest.approx(dynamics(other, [1, 2, 3, 4], [5, 6]), rel=1e-15)


@pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)
def test_proportional_derivative_feedback(build: Callable[[float], Robot]) -> None:
    robot = build(0.0)
    feedback = numeric([robot.system.x], robot.proportional_derivative(k_p=10.0, k_d=5.0))

    assert feedback([1, 2, 3, 4]).tolist() == [-25, -40]


@pytest.mark.parametrize(("gamma_1", "gain"), [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (3.0, 2.0), (10.0, 9.0)])
@pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)
def test_fail_safe_brakes_with_the_first_class_k_gain(
    build: Callable[[float], Robot], gamma_1: float, gain: float
) -> None:
    robot = build(gamma_1)
    law = numeric([robot.system.x], robot.fail_safe)

    assert robot.fail_safe_gain == gain
    assert law([1, 2, 3, 4]) == pytest.approx([-gain * 3, -gain * 4])
    assert f"γ₁ ≤ {1.0 + gain:g}/s" in robot.fail_safe_condition


@pytest.mark.parametrize(
    ("gamma_1", "gamma_2", "sigma", "lag_s", "poles"),
    [
        (0.0, 0.0, 1.0, 0.1, (1.0, 10.0)),
        (4.0, 5.0, 1.0, 0.5, (4.0, 5.0)),
        (4.0, 3.0, 1.0, 0.5, (4.0, 4.0)),
        (4.0, 5.0, 1.0, 0.1, (4.0, 10.0)),
        (1.0, 5.0, 3.0, 1.0, (1.0, 5.0)),
    ],
)
def test_lagged_fail_safe_places_the_poles_of_the_velocity(
    gamma_1: float, gamma_2: float, sigma: float, lag_s: float, poles: tuple[float, float]
) -> None:
    robot = lagged_point(sigma=sigma, lag_s=lag_s, gamma_1=gamma_1, gamma_2=gamma_2)
    closed = ca.substitute(robot.system.f, robot.system.u, robot.fail_safe)
    A = np.array(ca.DM(ca.simplify(ca.jacobian(closed, robot.system.x))).full())

    assert sorted(np.abs(np.linalg.eigvals(A[2:, 2:]))) == pytest.approx(sorted(poles * 2), rel=1e-6)
    assert f"γ₁ ≤ {poles[0]:g}/s and γ₁, γ₂ ≤ {poles[1]:g}/s" in robot.fail_safe_condition
    if (sigma, 1 / lag_s) in {poles, poles[::-1]}:
        assert numeric([robot.system.x], robot.fail_safe)(np.ones(6)) == pytest.approx([0, 0], abs=1e-15)


def test_a_saturating_drive_never_gives_more_than_it_has() -> None:
    robot = saturating_point(sigma=1.0, force=2.0)

    assert dynamics(robot, [0, 0, 0, 0], [3e8, 4e8]) == pytest.approx([0, 0, 1.2, 1.6])
    assert dynamics(robot, [0, 0, 0, 0], [3e-9, 4e-9]) == pytest.approx([0, 0, 3e-9, 4e-9])


@pytest.mark.parametrize(("gamma_1", "top_speed"), [(3.0, "8.66025"), (1.0, "inf"), (0.0, "inf")])
def test_saturating_fail_safe_states_its_largest_speed(gamma_1: float, top_speed: str) -> None:
    robot = saturating_point(sigma=1.0, force=20.0, gamma_1=gamma_1)

    assert robot.fail_safe_condition.startswith(f"speed at most {top_speed} m/s; ")


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: damped_point(sigma=0.0), "damped point sigma: got 0.0, allowed a positive finite number, 1/s"),
        (lambda: damped_point(sigma=nan), "damped point sigma: got nan, allowed a positive finite number, 1/s"),
        (lambda: drag_point(sigma=-1.0), "drag point sigma: got -1.0, allowed a positive finite number, 1/s"),
        (lambda: drag_point(drag=-0.1), "drag point drag: got -0.1, allowed zero or a positive finite number, 1/m"),
        (lambda: drag_point(drag=nan), "drag point drag: got nan, allowed zero or a positive finite number, 1/m"),
        (lambda: lagged_point(sigma=inf), "lagged point sigma: got inf, allowed a positive finite number, 1/s"),
        (lambda: lagged_point(lag_s=0.0), "lagged point lag_s: got 0.0, allowed a positive finite number, s"),
        (
            lambda: lagged_point(gamma_2=-1.0),
            "lagged point gamma_2: got -1.0, allowed zero or a positive finite number, 1/s",
        ),
        (lambda: saturating_point(sigma=0.0), "saturating point sigma: got 0.0, allowed a positive finite number, 1/s"),
        (lambda: saturating_point(force=-2), "saturating point force: got -2, allowed a positive finite number, N/kg"),
        (lambda: two_points(sigma=0.0), "two points sigma: got 0.0, allowed a positive finite number, 1/s"),
        (lambda: joint_chain(sigma=0.0), "joint chain sigma: got 0.0, allowed a positive finite number, 1/s"),
        (lambda: joint_chain(joints=0), "joint chain joints: got 0, allowed 1 to 7"),
        (lambda: joint_chain(joints=8), "joint chain joints: got 8, allowed 1 to 7"),
    ],
)
def test_numbers_that_make_no_robot_are_refused(build: Callable[[], Robot], message: str) -> None:
    with pytest.raises(DesignError) as refused:
        build()

    assert str(refused.value) == message


@pytest.mark.parametrize("build", [damped_point, drag_point, lagged_point, saturating_point, two_points, joint_chain])
def test_nan_class_k_gain_makes_no_fail_safe(build: Callable[..., Robot]) -> None:
    with pytest.raises(DesignError, match="gamma_1"):
        build(gamma_1=nan)


@pytest.mark.parametrize("joints", [1, 7])
def test_a_chain_has_as_many_joints_as_asked_for(joints: int) -> None:
    robot = joint_chain(joints=joints)

    assert (robot.system.n, robot.system.m, robot.position.numel(), robot.points) == (2 * joints, joints, joints, 0)


def disk(x1: Array) -> float:
    return float(x1 @ x1 - 1)


def disk_slope(x1: Array) -> Array:
    return 2 * x1


def wall(x1: Array) -> float:
    return float(x1 @ [0.6, 0.8] - 0.5)


def wall_slope(_: Array) -> Array:
    return np.array([0.6, 0.8])


SETS = {"disk": (disk, disk_slope), "half-plane": (wall, wall_slope)}


def handed_over(rng: np.random.Generator, gamma_1: float, safe_set: str) -> Array:
    """Draw a state in the safe set with ψ₁ = ḣ + γ₁h ≥ 0, often as fast towards the boundary as that allows."""
    h, slope = SETS[safe_set]
    while True:
        x1 = rng.uniform(-3, 3, 2)
        if h(x1) < 0:
            continue
        x2 = rng.normal(size=2) * 10 ** rng.uniform(-2, 1.5)
        towards = slope(x1) @ x2
        if towards < 0 and (rng.uniform() < 0.5 or towards < -gamma_1 * h(x1)):
            x2 *= -gamma_1 * h(x1) / towards  # now ψ₁ = 0
        if np.linalg.norm(x2) <= TOP_SPEED:
            return np.concatenate([x1, x2])


def lowest_h(plant: SampledPlant, law: Callable[..., Array], start: Array, safe_set: str, steps: int) -> float:
    """Smallest h on the way when the sampled fail-safe is applied from a state on."""
    h, _ = SETS[safe_set]
    x, lowest = start, h(start[:2])
    for _ in range(steps):
        x = np.asarray(plant.advance(list(x), list(law(x))).x, dtype=float)
        lowest = min(lowest, h(x[:2]))
    return lowest


@pytest.mark.parametrize("safe_set", SETS)
@pytest.mark.parametrize("gamma_1", [0.4, 3.0, 10.0])
@pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)
def test_fail_safe_keeps_the_set_from_states_with_psi_1_ok(
    build: Callable[[float], Robot], gamma_1: float, safe_set: str
) -> None:
    """Also with the input held between samples: a held −Kx₂ only brakes harder."""
    robot = build(gamma_1)
    plant = SampledPlant(robot.system, ca.sumsqr(robot.system.x), 1e-2)
    K = robot.fail_safe_gain
    rng = np.random.default_rng(80)
    for _ in range(15):
        start = handed_over(rng, gamma_1, safe_set)

        assert lowest_h(plant, lambda x: -K * x[2:], start, safe_set, 100) >= -1e-12


@pytest.mark.parametrize("safe_set", SETS)
def test_a_fail_safe_that_brakes_less_does_not_keep_the_set(safe_set: str) -> None:
    robot = BUILDERS["damped point"](10.0)
    plant = SampledPlant(robot.system, ca.sumsqr(robot.system.x), 1e-2)
    rng = np.random.default_rng(81)
    starts = [handed_over(rng, 10.0, safe_set) for _ in range(15)]

    assert min(lowest_h(plant, lambda x: -4.0 * x[2:], start, safe_set, 100) for start in starts) < -0.01


def test_sampled_fail_safe_stops_at_the_closed_form_place() -> None:
    """x₁ + s x₂ with s = (1 − K·dt/(q(σ + K)))/σ and q = (1 − e^{−σdt})/σ: short of 1/(σ + K), the unsampled path."""
    sigma, gamma_1 = 0.8, 6.0
    robot = damped_point(sigma=sigma, gamma_1=gamma_1)
    K = robot.fail_safe_gain
    plant = SampledPlant(robot.system, ca.sumsqr(robot.system.x), DT_S)
    law = numeric([robot.system.x], robot.fail_safe)
    start = x = np.array([1.0, -2.0, 5.0, 3.0])
    for _ in range(1000):
        x = np.asarray(plant.advance(list(x), list(law(x))).x, dtype=float)
    q = (1 - exp(-sigma * DT_S)) / sigma
    s = (1 - K * DT_S / (q * (sigma + K))) / sigma

    assert x == pytest.approx([*(start[:2] + s * start[2:]), 0, 0], abs=1e-9)
    assert 0 < s < 1 / (sigma + K)
    assert s == pytest.approx(1 / (sigma + K), rel=3e-2)
