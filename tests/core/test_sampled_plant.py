from math import exp, inf, nan

import casadi as ca
import numpy as np
import pytest
from core_designs import random_state
from finite_differences import Array, numeric
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from passafe.errors import DesignError, IntegrationError, ShapeError
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.robot import Robot
from passafe.sampled_plant import LOCAL_TOLERANCE, MAX_SUBSTEPS, SampledPlant, held_flow, is_linear
from passafe.system import System

x, u = ca.SX.sym("x", 2), ca.SX.sym("u")


def plant_of(robot: Robot, dt_s: float) -> SampledPlant:
    return SampledPlant(robot.system, ca.sumsqr(robot.system.x), dt_s)


def truth(system: System, start: Array, held: Array, dt_s: float) -> tuple[Array, float]:
    """X and ∫yᵀu after a period, by an independent method of order 8 at the tightest tolerance."""
    flow, output = numeric([system.x, system.u], system.f), numeric([system.x], system.y)

    def rate(_: float, s: Array) -> Array:
        return np.append(flow(s[:-1], held), output(s[:-1]) @ held)

    end = solve_ivp(rate, (0, dt_s), np.append(start, 0.0), method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return end[:-1], float(end[-1])


@pytest.mark.parametrize(
    ("f", "y", "linear"),
    [
        (ca.vertcat(x[1], u - 2 * x[0]), x[1], True),
        (ca.vertcat(x[1] + 3, u - 9.81), x[1] + 1, True),
        (ca.vertcat(x[1], u - ca.sin(x[0])), x[1], False),
        (ca.vertcat(x[1], u * x[0]), x[1], False),
        (ca.vertcat(x[1], u**2), x[1], False),
        (ca.vertcat(x[1], u), x[1] ** 3, False),
    ],
)
def test_linear_is_what_is_linear_up_to_constants(f: ca.SX, y: ca.SX, *, linear: bool) -> None:
    system = System(x=x, u=u, f=f, y=y)

    assert is_linear(system) is linear
    assert SampledPlant(system, ca.sumsqr(x), 1e-3).exact is linear


@pytest.mark.parametrize("dt_s", [1e-3, 0.1, 2.0])
@pytest.mark.parametrize("sigma", [0.3, 1.0, 40.0])
def test_damped_point_is_exact_in_closed_form(sigma: float, dt_s: float) -> None:
    """x₂ ← e^{−σt}x₂ + q u, x₁ ← x₁ + q x₂ + (t − q)/σ·u with q = (1 − e^{−σt})/σ; as y = ẋ₁, ∫yᵀu = (Δx₁)ᵀu."""
    plant = plant_of(damped_point(sigma=sigma), dt_s)
    rng = np.random.default_rng(70)
    decay = exp(-sigma * dt_s)
    q = (1 - decay) / sigma
    for _ in range(20):
        start, held = random_state(rng, 4), random_state(rng, 2, 20)
        sample = plant.advance(list(start), list(held))
        x1 = start[:2] + q * start[2:] + (dt_s - q) / sigma * held
        x2 = decay * start[2:] + q * held

        assert sample.x == pytest.approx([*x1, *x2], rel=1e-12, abs=1e-12)
        assert sample.y == sample.x[2:]
        assert sample.energy_in_j == pytest.approx((x1 - start[:2]) @ held, rel=1e-11, abs=1e-12)
        assert sample.stored_j == pytest.approx(x1 @ x1 + x2 @ x2)
        assert sample.integration_error == 0.0


def test_linear_systems_with_constants_are_exact() -> None:
    rng = np.random.default_rng(71)
    A, B, C, f0, y0 = (rng.normal(size=size) for size in ((3, 3), (3, 2), (2, 3), 3, 2))
    state, held = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
    system = System(x=state, u=held, f=ca.DM(A) @ state + ca.DM(B) @ held + ca.DM(f0), y=ca.DM(C) @ state + ca.DM(y0))
    dt_s = 0.3
    plant = SampledPlant(system, ca.sumsqr(state), dt_s)
    for _ in range(10):
        start, value = random_state(rng, 3), random_state(rng, 2)
        # ẋ = Ax + c is the flow of [[A, c], [0, 0]], and ∫y one more row of it
        M = np.zeros((6, 6))
        M[:3, :3], M[:3, 5], M[3:5, :3], M[3:5, 5] = A, B @ value + f0, C, y0
        end = expm(M * dt_s) @ [*start, 0, 0, 1]
        sample = plant.advance(list(start), list(value))

        assert sample.x == pytest.approx(end[:3], rel=1e-12)
        assert sample.energy_in_j == pytest.approx(end[3:5] @ value, rel=1e-11)
        assert sample.y == pytest.approx(C @ end[:3] + y0, rel=1e-12)


@pytest.mark.parametrize(("robot", "accuracy"), [(damped_point(), 1e-14), (drag_point(), 1e-12)])
def test_two_half_periods_are_one_period(robot: Robot, accuracy: float) -> None:
    whole, half = plant_of(robot, 4e-3), plant_of(robot, 2e-3)
    rng = np.random.default_rng(72)
    for _ in range(20):
        start, held = random_state(rng, 4), random_state(rng, 2, 10)
        once = whole.advance(list(start), list(held))
        first = half.advance(list(start), list(held))
        second = half.advance(first.x, list(held))

        assert second.x == pytest.approx(once.x, abs=10 * accuracy)
        assert first.energy_in_j + second.energy_in_j == pytest.approx(once.energy_in_j, abs=100 * accuracy)


@pytest.mark.parametrize("dt_s", [1e-3, 2e-2])
def test_drag_point_keeps_its_stated_accuracy(dt_s: float) -> None:
    robot = drag_point(sigma=0.5, drag=0.5)
    plant = plant_of(robot, dt_s)
    rng = np.random.default_rng(73)
    assert not plant.exact
    for _ in range(8):
        start, held = random_state(rng, 4, 3), random_state(rng, 2, 20)
        sample = plant.advance(list(start), list(held))
        end, energy = truth(robot.system, start, held, dt_s)

        assert sample.integration_error <= LOCAL_TOLERANCE
        assert sample.x == pytest.approx(end, abs=LOCAL_TOLERANCE)
        assert sample.energy_in_j == pytest.approx(energy, abs=50 * LOCAL_TOLERANCE)


def test_energy_is_integrated_by_booles_rule() -> None:
    """With x = ut and y = x⁴, ∫yu dt = u⁵h⁵/5. Two steps of Simpson's rule and a whole one make Boole's."""
    state, held = ca.SX.sym("x"), ca.SX.sym("u")
    plant = SampledPlant(System(x=state, u=held, f=held, y=state**4), state**2, 0.1)
    end, _, _, energy, _ = plant.step(0.0, 2.0, 1.5)

    assert float(end) == 3.0
    assert float(energy) == pytest.approx(2.0**5 * 1.5**5 / 5, rel=1e-13)


def test_a_fast_start_is_integrated_in_substeps() -> None:
    robot = drag_point(sigma=0.5, drag=0.5)
    start, held, dt_s = np.array([1.0, 2.0, 20.0, -7.0]), np.array([2.0, -1.0]), 0.1
    single = numeric([robot.system.x, robot.system.u], held_flow(robot.system, dt_s)[2])
    sample = plant_of(robot, dt_s).advance(list(start), list(held))
    end, energy = truth(robot.system, start, held, dt_s)

    assert single(start, held)[0] > 1e-3  # one step would be far off
    assert 0 < sample.integration_error <= LOCAL_TOLERANCE
    assert sample.x == pytest.approx(end, abs=10 * LOCAL_TOLERANCE)
    assert sample.energy_in_j == pytest.approx(energy, abs=100 * LOCAL_TOLERANCE)
    assert sample.stored_j == pytest.approx(end @ end)


def test_energy_of_a_heavy_vehicle_is_judged_by_its_share() -> None:
    """A truck at 30 m/s brakes with 10⁵ N for 0.1 s: 3·10⁵ J, of which the last bit is 6·10⁻¹¹ J."""
    speed, force, mass = ca.SX.sym("v"), ca.SX.sym("u"), 2e4
    truck = System(x=speed, u=force, f=(force - 50 - 2.5 * speed**2) / mass, y=speed)
    plant = SampledPlant(truck, mass * speed**2 / 2, 0.1)
    for start in np.linspace(10.0, 40.0, 301):
        sample = plant._step((start,), (-1e5,), 0.1)
        end, energy = truth(truck, np.array([start]), np.array([-1e5]), 0.1)

        assert sample.integration_error <= LOCAL_TOLERANCE
        assert sample.x == pytest.approx(end, abs=10 * LOCAL_TOLERANCE)
        assert sample.energy_in_j == pytest.approx(energy, rel=100 * LOCAL_TOLERANCE)


def test_period_that_cannot_be_integrated_is_refused() -> None:
    plant = plant_of(drag_point(drag=50.0), 0.5)

    with pytest.raises(IntegrationError) as refused:
        plant.advance((0.0, 0.0, 20.0, 0.0), (0.0, 0.0))

    assert refused.value.error > refused.value.tolerance == LOCAL_TOLERANCE
    assert refused.value.substeps == MAX_SUBSTEPS


@pytest.mark.parametrize("start", [(0, 0, nan, 0), (0, 0, inf, 0), (0, 0, 1e200, 1), (nan, 0, 0, 0)])
def test_a_step_that_is_no_number_is_not_called_accurate(start: tuple[float, ...]) -> None:
    with pytest.raises(IntegrationError):
        plant_of(drag_point(), 1e-3).advance(start, (0.0, 0.0))


def test_energy_of_a_curved_output_is_as_accurate_as_the_state() -> None:
    """X = ∫u is integrated exactly by any step, ∫sin(x)·u is not: V and the ledger need both."""
    position, held = ca.SX.sym("x"), ca.SX.sym("u")
    system = System(x=position, u=held, f=held, y=ca.sin(position))
    sample = SampledPlant(system, position**2, 1.0).advance((0.0,), (4.0,))

    assert sample.x == pytest.approx([4.0])
    assert sample.energy_in_j == pytest.approx(1 - np.cos(4.0), abs=100 * LOCAL_TOLERANCE)


def test_step_has_fifth_order_and_its_estimate_fourth() -> None:
    """ẋ = −x² from x = 1 is x = 1/(1 + t): halving a step divides its error by 2⁶ at least, the estimate by 2⁵."""
    state, held, h = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("h")
    system = System(x=state, u=held, f=held - state**2, y=state)
    flow = numeric([state, held, h], ca.vertcat(*held_flow(system, h)))
    error, estimate = {}, {}
    for step in (0.1, 0.05, 0.025):
        end, _, estimate[step] = flow(1.0, 0.0, step)
        error[step] = abs(end - 1 / (1 + step))

    assert min(error[0.1] / error[0.05], error[0.05] / error[0.025]) > 2**6
    assert estimate[0.05] / estimate[0.025] == pytest.approx(2**5, rel=0.15)
    assert all(error[step] < estimate[step] for step in error)


def test_a_held_flow_reaches_any_moment_of_the_period() -> None:
    robot = damped_point()
    plant = plant_of(robot, 0.3)
    start, held = [1.0, 2.0, 3.0, 4.0], [5.0, 6.0]
    x_next, energy, error = (numeric([robot.system.x, robot.system.u], part) for part in held_flow(robot.system, 0.3))
    sample = plant.advance(list(start), list(held))

    assert x_next(start, held) == pytest.approx(sample.x, rel=1e-14)
    assert energy(start, held)[0] == pytest.approx(sample.energy_in_j, rel=1e-14)
    assert error(start, held)[0] == 0.0


def test_a_state_that_no_period_led_to() -> None:
    sample = plant_of(damped_point(), 1e-3).at([1, 2, 3, 4])

    assert sample.x == (1.0, 2.0, 3.0, 4.0)
    assert sample.y == (3.0, 4.0)
    assert (sample.stored_j, sample.energy_in_j, sample.integration_error) == (30.0, 0.0, 0.0)


@pytest.mark.parametrize("sizes", [(3, 2), (5, 2), (4, 1), (4, 3), (3, 3), (5, 1), (0, 6)])
@pytest.mark.parametrize("robot", [damped_point(), drag_point()])
def test_wrong_lengths_are_refused(robot: Robot, sizes: tuple[int, int]) -> None:
    plant = plant_of(robot, 1e-3)

    with pytest.raises(ShapeError) as refused:
        plant.advance([0.0] * sizes[0], [0.0] * sizes[1])

    assert str(refused.value) == f"x, u: got lengths {sizes[0]}, {sizes[1]}, allowed lengths 4, 2"


@pytest.mark.parametrize("size", [0, 1, 3, 5])
def test_a_state_of_the_wrong_length_is_refused(size: int) -> None:
    with pytest.raises(ShapeError, match="x: got"):
        plant_of(damped_point(), 1e-3).at([1.0] * size)


def test_a_storage_is_a_scalar_function_of_the_state() -> None:
    system = damped_point().system

    with pytest.raises(ShapeError, match="storage V: got shape"):
        SampledPlant(system, system.x, 1e-3)
    with pytest.raises(DesignError, match="storage V: got the symbols"):
        SampledPlant(system, ca.sumsqr(system.u), 1e-3)
