"""Properties of every shipped robot and storage function.

A robot enters by a subclass of ``PlantSuite`` that names its entry in ``shipped_robots``, a storage function by one
of ``StorageSuite`` that also says V in plain numbers.
"""

from collections.abc import Callable, Iterator
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest
from finite_differences import Array, runge_kutta
from shipped_robots import ROBOTS, Shipped, columns

from passafe.models.robot import Robot
from passafe.passivity import power_margin
from passafe.sampled_plant import SampledPlant
from passafe.storage import kinetic_energy

DT_S, FINE = 5e-3, 20
GAINS = (4.0, 5.0)


def held_inputs(shipped: Shipped, robot: Robot, seed: int, count: int = 20) -> Iterator[tuple[Array, Array]]:
    """Yield random states, some of them at rest, and inputs, some of them zero and some a hundred times the others."""
    rng = np.random.default_rng(seed)
    system = robot.system
    for j in range(count):
        x = rng.uniform(-3, 3, system.n)
        if j % 4 == 0:
            x[shipped.coordinates :] = 0.0
        yield x, rng.uniform(-3, 3, system.m) * (0.0, 1.0, 1.0, 100.0)[j % 4]


def finely(shipped: Shipped, x: Array, u: Array, rates: Callable[[Array], Array], duration_s: float) -> Array:
    """Return x and the integrals of ``rates`` after a while with u held, by many small Runge–Kutta steps."""
    n = len(x)
    s = np.concatenate([x, np.zeros_like(rates(x))])
    for _ in range(FINE):
        s = runge_kutta(lambda _, s: np.concatenate([shipped.rate(s[:n], u), rates(s[:n])]), 0.0, s, duration_s / FINE)
    return s


class PlantSuite:
    """Inherit, and name the robot.

    Attributes:
        name: Key in ``shipped_robots.ROBOTS``.
    """

    name: ClassVar[str]

    @pytest.fixture(params=[0.0, GAINS[0]])
    def robot(self, request: pytest.FixtureRequest) -> Robot:
        return self.shipped.build(request.param, GAINS[1])

    @property
    def shipped(self) -> Shipped:
        return ROBOTS[self.name]

    def test_dynamics_are_those_written_a_second_time(self, robot: Robot) -> None:
        f = columns([robot.system.x, robot.system.u], robot.system.f)
        for x, u in held_inputs(self.shipped, robot, 1):
            assert f(x[:, None], u[:, None])[:, 0] == pytest.approx(self.shipped.rate(x, u), rel=1e-12, abs=1e-12)

    def test_positions_come_before_velocities_which_are_the_output(self, robot: Robot) -> None:
        k, x = self.shipped.coordinates, robot.system.x
        for part, expected in (
            (robot.position, x[:k]),
            (robot.velocity, x[k : 2 * k]),
            (robot.system.y, x[k : 2 * k]),
            (robot.system.f[:k], x[k : 2 * k]),
        ):
            assert ca.is_equal(part, expected, 5)
        assert robot.points in {0, k / 2}

    def test_a_period_is_what_many_small_steps_make_of_it(self, robot: Robot) -> None:
        plant = SampledPlant(robot.system, kinetic_energy(robot.velocity), DT_S)
        assert plant.exact is self.shipped.linear
        k = self.shipped.coordinates
        for x, u in held_inputs(self.shipped, robot, 2):
            sample = plant.advance(x.tolist(), u.tolist())
            expected = finely(self.shipped, x, u, lambda s, u=u: np.array([s[k : 2 * k] @ u]), DT_S)
            assert sample.x == pytest.approx(expected[:-1], rel=1e-9, abs=1e-9)
            assert sample.energy_in_j == pytest.approx(expected[-1], rel=1e-9, abs=1e-9)

    def test_two_halves_are_a_whole_period(self, robot: Robot) -> None:
        whole = SampledPlant(robot.system, kinetic_energy(robot.velocity), DT_S)
        half = SampledPlant(robot.system, kinetic_energy(robot.velocity), DT_S / 2)
        for x, u in held_inputs(self.shipped, robot, 3):
            once = half.advance(x.tolist(), u.tolist())
            twice = half.advance(once.x, u.tolist())
            sample = whole.advance(x.tolist(), u.tolist())
            assert twice.x == pytest.approx(sample.x, rel=1e-9, abs=1e-9)
            assert once.energy_in_j + twice.energy_in_j == pytest.approx(sample.energy_in_j, rel=1e-9, abs=1e-9)
            assert twice.stored_j == pytest.approx(sample.stored_j, rel=1e-9, abs=1e-9)

    def test_the_fail_safe_brings_it_to_rest_within_its_hull(self, robot: Robot) -> None:
        """In every direction no place of the path lies beyond the furthest corner of the hull."""
        k, n = self.shipped.coordinates, robot.system.n
        law = columns([robot.system.x], robot.fail_safe)
        corners = columns([robot.system.x], ca.vertcat(*robot.stopping_hull))
        rng = np.random.default_rng(4)
        directions = rng.normal(size=(100, k))
        assert not law(np.vstack([rng.normal(size=(k, 1)), np.zeros((n - k, 1))])).any()
        x = rng.uniform(-3, 3, (n, 20))
        hull = np.einsum("dk,ckj->dcj", directions, corners(x).reshape(-1, k, 20)).max(axis=1)
        for _ in range(4000):
            x = runge_kutta(lambda _, s: self.shipped.rate(s, law(s)), 0.0, x, DT_S)
            assert (directions @ x[:k] <= hull + 1e-8).all()
        assert np.abs(x[k:]).max() < 1e-4

    def test_what_the_fail_safe_keeps_is_said(self, robot: Robot) -> None:
        assert "ψ₁" in robot.fail_safe_condition
        assert "/s" in robot.fail_safe_condition
        braking = columns([robot.system.x], ca.jacobian(robot.fail_safe, robot.velocity))
        assert braking(np.ones((robot.system.n, 1))) == pytest.approx(-robot.fail_safe_gain * np.eye(robot.system.m))


class StorageSuite:
    """Inherit, and say V in plain numbers. It is tested on every robot.

    Attributes:
        name: How it is called.
    """

    def storage(self, robot: Robot) -> ca.SX:
        """Return V on a robot."""
        raise NotImplementedError

    def energy(self, x: Array, coordinates: int) -> float:
        """Return V, without using it."""
        raise NotImplementedError

    @pytest.fixture(params=ROBOTS)
    def shipped(self, request: pytest.FixtureRequest) -> Shipped:
        return ROBOTS[request.param]

    @pytest.fixture
    def robot(self, shipped: Shipped) -> Robot:
        return shipped.build(*GAINS)

    def test_it_is_what_is_said_and_zero_at_rest_in_the_origin(self, shipped: Shipped, robot: Robot) -> None:
        V = columns([robot.system.x], self.storage(robot))
        assert V(np.zeros((robot.system.n, 1)))[0, 0] == 0.0
        for x, _ in held_inputs(shipped, robot, 5):
            assert V(x[:, None])[0, 0] == pytest.approx(self.energy(x, shipped.coordinates), rel=1e-12)
            assert V(x[:, None])[0, 0] >= 0.0

    def test_energy_in_is_what_is_stored_and_what_is_dissipated(self, shipped: Shipped, robot: Robot) -> None:
        """∫yᵀu dt = ΔV + ∫h_u dt over a period, h_u integrated finely along the independent dynamics."""
        V = self.storage(robot)
        plant = SampledPlant(robot.system, V, DT_S)
        h_u = columns([robot.system.x, robot.system.u], power_margin(robot.system, V))
        for x, u in held_inputs(shipped, robot, 6):
            after = plant.advance(x.tolist(), u.tolist())
            whole = finely(shipped, x, u, lambda s, u=u: h_u(s[:, None], u[:, None])[0], DT_S)
            gained = after.stored_j - self.energy(x, shipped.coordinates)
            assert after.energy_in_j - gained == pytest.approx(whole[-1], rel=1e-6, abs=1e-9)
