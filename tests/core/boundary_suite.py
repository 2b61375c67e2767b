"""Properties of every shipped barrier, at states on and near its boundary.

A shape enters by a subclass of ``BarrierSuite`` that says, without using the shape, where its boundary runs and on
which side it is safe. It is then tested on every robot that has such coordinates.
"""

from collections.abc import Callable
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest
from boundary_case import NEAR, Case, OnBoundary
from finite_differences import Array, runge_kutta
from shipped_robots import columns

from passafe.class_k import ClassK, Cubic, Linear
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.robot import Robot
from passafe.passivity import Passivity
from passafe.storage import kinetic_energy

SMOOTH: tuple[ClassK, ...] = (Linear(gain=3.0), Cubic(gain=0.5), Linear(gain=2.0), Linear(gain=1.0))
STRAIGHT: tuple[ClassK, ...] = (Linear(gain=4.0), Linear(gain=5.0), Linear(gain=6.0), Linear(gain=1.0))
STEP, DT_S = 1e-3, 1e-3
AMPLE = 3.0
"""ψ_r that some input must reach for a state to be one from which the filter is asked to keep the barrier."""


class BarrierSuite:
    """Inherit, and say what is known of the shape without using it.

    Attributes:
        of: What the shape is a function of: position or velocity.
        robots: Names of the robots that have such coordinates.
        shape: ``affine``, ``convex`` or ``concave`` in those coordinates.
        moves: Whether the set moves.
    """

    of: ClassVar[str] = "position"
    robots: ClassVar[tuple[str, ...]]
    shape: ClassVar[str]
    moves: ClassVar[bool] = False

    def h(self, robot: Robot) -> ca.SX:
        """Return the shape on a robot."""
        raise NotImplementedError

    def inside(self, place: Array, t: float) -> bool:
        """Check geometrically whether a position is safe."""
        raise NotImplementedError

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        """Return a random place on the boundary."""
        raise NotImplementedError

    @pytest.fixture
    def case(self, robot_name: str) -> Case:
        return Case(self, robot_name, SMOOTH)

    @pytest.fixture
    def straight(self, robot_name: str) -> Case:
        return Case(self, robot_name, STRAIGHT)

    def test_h_is_positive_exactly_where_it_is_safe(self, case: Case) -> None:
        x, u, t = case.samples(1)
        distance = np.repeat(NEAR, 3)
        h = case.psi[0](x, u, t)[0]
        assert np.abs(h[distance == 0]).max() <= 1e-13 * 100
        assert (np.sign(h[distance != 0]) == np.sign(distance[distance != 0])).all()
        assert [self.inside(x[case.rows, j], t[0, j]) for j in np.flatnonzero(distance)] == list(
            distance[distance != 0] > 0
        )
        rng = np.random.default_rng(2)
        x = rng.uniform(-6, 6, (case.robot.system.n, 500))
        t = rng.uniform(0, 5, (1, 500))
        safe = [self.inside(x[case.rows, j], t[0, j]) for j in range(500)]
        assert list(case.psi[0](x, u[:, :1], t)[0] > 0) == safe
        assert 0 < sum(safe) < 500

    def test_h_grows_straight_into_the_safe_set(self, case: Case) -> None:
        rng = np.random.default_rng(3)
        for _ in range(50):
            t = rng.uniform(0, 5)
            place, inward = self.on_boundary(rng, t)
            x = rng.uniform(-2, 2, (case.robot.system.n, 1))
            x[case.rows, 0] = place
            slope = case.slope[0](x, np.zeros((case.robot.system.m, 1)), np.array([[t]]))[:-1, 0]
            assert slope[case.rows] / np.linalg.norm(slope) == pytest.approx(inward, abs=1e-12)

    def test_the_input_appears_where_the_relative_degree_says(self, case: Case) -> None:
        assert case.chain.relative_degree == case.degree
        assert not any(ca.depends_on(psi, case.robot.system.u) for psi in case.chain.psi[:-1])

    def test_the_input_acts_on_every_boundary(self, case: Case) -> None:
        x, u, t = case.samples(4)
        gradient = columns(case.symbols, ca.gradient(case.chain.psi[-1], case.robot.system.u))(x, u, t)
        difference = _slope(lambda held: case.psi[-1](x, held, t)[0], u)
        assert gradient == pytest.approx(difference, rel=1e-6, abs=1e-6)
        assert np.linalg.norm(gradient, axis=0).min() > 0.1

    def test_gradients_are_those_of_finite_differences(self, case: Case) -> None:
        for x, u, t in case.everywhere(5):
            for psi, slope in zip(case.psi, case.slope, strict=True):
                difference = _slope(lambda s, psi=psi, u=u: psi(s[:-1], u, s[-1:])[0], np.vstack([x, t]))
                assert slope(x, u, t) == pytest.approx(difference, rel=1e-6, abs=1e-6)

    def test_psi_is_the_previous_rate_plus_its_class_k_function(self, case: Case) -> None:
        for x, u, t in case.everywhere(6):
            for i in range(case.degree):
                rate = _rate_along(case, i, x, u, t)
                before = case.psi[i](x, u, t)[0]
                gain = case.barrier.class_k[i].gain
                gamma = gain * before**3 if isinstance(case.barrier.class_k[i], Cubic) else gain * before
                assert case.psi[i + 1](x, u, t)[0] == pytest.approx(rate + gamma, rel=1e-6, abs=1e-6)

    def test_the_filter_keeps_it_for_a_period_whatever_is_asked_for(self, straight: Case) -> None:
        made = _filter(straight)
        x, t = straight.protected(7)
        within_reach = _largest_psi_r(straight, x, t) > AMPLE
        x, t = x[:, within_reach], t[:, within_reach]
        assert x.shape[1] > 10
        rng = np.random.default_rng(8)
        zero = [0.0] * straight.robot.system.m
        for j in range(0, x.shape[1], 3):
            wish = rng.uniform(-20, 20, len(zero)).tolist()
            decision = made.decide(x[:, j].tolist(), zero, wish, zero, 0.0, t[0, j], start=True)
            assert decision.status in {Status.PASSED, Status.MODIFIED}
            u = np.array(decision.u)
            s = np.append(x[:, j], t[0, j])
            for _ in range(5):
                s = runge_kutta(lambda _, s, u=u: np.append(straight.shipped.rate(s[:-1], u), 1.0), 0.0, s, DT_S / 5)
                for psi in straight.psi[:-1]:
                    assert psi(s[:-1, None], u[:, None], s[-1:, None])[0, 0] >= -1e-12

    def test_the_fail_safe_keeps_it_under_its_condition(self, straight: Case) -> None:
        if self.moves:  # no law that brings a robot to rest keeps it out of the way of what moves
            assert "no obstacle that moves by itself" in straight.robot.fail_safe_condition
            return
        x = _under_the_condition(straight)
        system = straight.robot.system
        law, h = columns([system.x], straight.robot.fail_safe), columns([system.x], straight.chain.psi[0])
        lowest = h(x).min()
        for _ in range(1500):
            u = law(x)
            x = runge_kutta(lambda _, s, u=u: straight.shipped.rate(s, u), 0.0, x, DT_S)
            lowest = min(lowest, h(x).min())
        # A law for relative degree 3 is proven in continuous time; held over periods it is off by their order.
        assert lowest >= -(1e-12 if straight.shipped.degree == 2 else DT_S)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give every suite its robots; to be imported by the modules that inherit."""
    if "robot_name" in metafunc.fixturenames:
        metafunc.parametrize("robot_name", metafunc.cls.robots)


def _slope(function: Callable[[Array], Array], at: Array) -> Array:
    """Gradient of a scalar function of columns, by fourth-order central differences; shape of ``at``."""
    partial = []
    for i in range(len(at)):
        step = np.zeros((len(at), 1))
        step[i] = STEP
        near = function(at + step) - function(at - step)
        far = function(at + 2 * step) - function(at - 2 * step)
        partial.append((8 * near - far) / (12 * STEP))
    return np.array(partial)


def _rate_along(case: Case, level: int, x: Array, u: Array, t: Array) -> Array:
    """D/dt of ψ_level along the independent dynamics, by a fourth-order central difference."""

    def flow(_: float, s: Array) -> Array:
        return np.vstack([case.shipped.rate(s[:-1], u), np.ones_like(t)])

    def value(s: Array) -> Array:
        return case.psi[level](s[:-1], u, s[-1:])[0]

    start = np.vstack([x, t])
    at = {}
    for sign in (1, -1):
        once = runge_kutta(flow, 0.0, start, sign * STEP)
        at[sign], at[2 * sign] = value(once), value(runge_kutta(flow, 0.0, once, sign * STEP))
    return (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * STEP)


def _filter(case: Case) -> SafetyPassivityFilter:
    system = case.robot.system
    return SafetyPassivityFilter(
        FilterDesign(
            system=system,
            u_fb=ca.SX.zeros(system.m),
            fail_safe=case.robot.fail_safe,
            barriers=(case.barrier,),
            passivity=Passivity(V=kinetic_energy(case.robot.velocity)),
            k_i=100.0,
            dt_s=DT_S,
            input_bound=case.shipped.input_bound,
            mode=Mode.SAFE,
        )
    )


def _largest_psi_r(case: Case, x: Array, t: Array) -> Array:
    """Largest ψ_r of some inputs of every direction within the bound."""
    m = case.robot.system.m
    directions = np.random.default_rng(10).normal(size=(200, m))
    directions /= np.abs(directions).max(axis=1, keepdims=True)
    inputs = case.shipped.input_bound * directions
    return np.max([case.psi[-1](x, u[:, None], t)[0] for u in inputs], axis=0)


def _under_the_condition(case: Case) -> Array:
    """Columns of x from which the robot's fail-safe is said to keep a shape that stands still."""
    x, t = case.protected(9)
    u = np.zeros((case.robot.system.m, 1))
    velocity = x[case.shipped.coordinates : 2 * case.shipped.coordinates]
    kept = np.linalg.norm(velocity, axis=0) <= case.shipped.top_speed(STRAIGHT[0].gain)
    system, robot = case.robot.system, case.robot
    if case.suite.of == "velocity":
        if case.shipped.degree > 2:  # v + a/κ₁ must be in the set as well: the second corner of the hull, in motion
            q = robot.stopping_hull[1]
            drift = columns([system.x], ca.jtimes(q, system.x, ca.substitute(system.f, system.u, robot.fail_safe)))
            there = x.copy()
            there[case.rows] = drift(x)
            kept &= case.psi[0](there, u, t)[0] >= 0
        return x[:, kept]
    if case.suite.shape == "concave":
        for corner in robot.stopping_hull:
            there = x.copy()
            there[case.rows] = columns([system.x], corner)(x)
            kept &= case.psi[0](there, u, t)[0] >= 0
    elif case.suite.shape == "convex" and case.shipped.degree > 2:
        bend = ca.bilin(
            ca.hessian(case.chain.psi[0], system.x)[0][case.rows, case.rows], robot.velocity, robot.velocity
        )
        kept &= case.psi[2](x, u, t)[0] >= columns([system.x], bend)(x)[0]
    assert kept.sum() > 5
    return x[:, kept]
