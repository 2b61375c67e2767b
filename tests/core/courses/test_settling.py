"""Settling of backup laws, and what is kept meanwhile: closed forms, and long rollouts."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from passafe.barrier_chain import Barrier, derive_chains
from passafe.class_k import Linear
from passafe.courses.backup_rollout import BackupRollout
from passafe.courses.course import Course
from passafe.courses.settling import Settling
from passafe.design import FilterDesign, Mode
from passafe.numerics.workspace import Array
from passafe.passivity import Passivity
from passafe.system import System

DT_S = 0.01
RATE_PER_S = 2.0


def design_of(system: System, law: ca.SX, h: ca.SX, *, degree: int = 2, bound: float = 1e3) -> FilterDesign:
    return FilterDesign(
        system=system,
        u_fb=ca.SX.zeros(system.m),
        fail_safe=law,
        barriers=(Barrier(name="h", h=h, class_k=(Linear(gain=1.0),) * (degree + 1)),),
        passivity=Passivity(V=ca.sumsqr(system.x)),
        k_i=1.0,
        dt_s=DT_S,
        input_bound=bound,
        mode=Mode.SAFE,
    )


def rollout(design: FilterDesign) -> BackupRollout:
    return BackupRollout(design, [chain for each in design.barriers for chain in derive_chains(design.system, each)])


def settling(design: FilterDesign) -> Settling:
    return rollout(design)._settling


def course(design: FilterDesign, *x: float) -> Course:
    return rollout(design).course(np.array(x), 0.0, np.zeros(design.system.m), 0)


def point(*, wall: float = 1.0) -> FilterDesign:
    """Return ẍ = u to stay left of a wall, with the law −2ẋ."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    return design_of(System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1]), -RATE_PER_S * x[1], wall - x[0])


def saturated(*, wall: float) -> FilterDesign:
    """Return the same with a law that saturates smoothly at 1 m/s²."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    law = -ca.tanh(RATE_PER_S * x[1])
    return design_of(System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1]), law, wall - x[0])


def follower(other: float) -> FilterDesign:
    """Return a car behind one whose speed tends slowly to another one: gap, speed, speed of the other."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[2] - x[1], u, 0.05 * (other - x[2])), y=x[1])
    return design_of(system, -RATE_PER_S * x[1], x[0] - 2.0)


def stopping_distance(v: float) -> float:
    """Return where ẍ = −2ẋ of the last sample comes to rest: v·T·Σ(1 − 2T)ᵏ less half of what u does in a period."""
    return v * DT_S * (1 - RATE_PER_S * DT_S / 2) / (RATE_PER_S * DT_S)


@pytest.mark.parametrize("v", [0.01, 0.3, 0.8, -3.0])
def test_bound_is_below_where_the_point_stops(v: float) -> None:
    """The bound from the first sample on is true; within 1 m of the wall it is no tighter than four times the way."""
    way = stopping_distance(v)
    lowest = settling(point()).lowest(np.array([0.0, v, 0.0, 0.0]))

    assert lowest <= 1 - max(way, 0.0)
    assert lowest >= 1 - 8 * abs(way)


@pytest.mark.parametrize(("v", "is_safe"), [(1.9, True), (2.1, False)])
def test_a_course_is_safe_up_to_the_stopping_distance(v: float, is_safe: bool) -> None:
    found = course(point(), 0.0, v)

    assert found.is_safe is is_safe
    assert found.lowest == pytest.approx(1 - stopping_distance(v), abs=1e-6 if not is_safe else 0.05)


def test_a_car_that_is_left_behind_is_safe_for_ever() -> None:
    """Its gap grows for good, and the other car takes minutes to settle: no state is ever at rest."""
    assert course(follower(10.0), 30.0, 8.0, 12.0).is_safe


def test_a_car_that_another_backs_into_is_not_safe() -> None:
    found = course(follower(-1.0), 30.0, 0.0, -1.0)

    assert found.lowest >= 0 or not found.comes_to_rest
    assert not found.is_safe


@pytest.mark.parametrize(("speed", "is_safe"), [(0.5, True), (-0.1, False)])
def test_a_wall_that_moves_is_kept_only_if_it_leaves(speed: float, is_safe: bool) -> None:
    x, u, t = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("t")
    system = System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1], t=t)
    wall = 1 + speed * t + 0.1 * ca.sin(3 * t) - x[0]

    assert course(design_of(system, -RATE_PER_S * x[1], wall), 0.0, 0.0).is_safe is is_safe


def test_a_speed_that_nothing_brakes_may_stay() -> None:
    """A puck slides on along x₀ for ever; a wall across x₁, along which it is braked, is kept, one across x₀ is not."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    system = System(x=x, u=u, f=ca.vertcat(x[2], x[3], u), y=x[2:])
    law = ca.vertcat(0, -RATE_PER_S * x[3])

    assert course(design_of(system, law, 1 - x[1]), 0.0, 0.0, 0.2, 0.3).is_safe
    assert not course(design_of(system, law, 1 - x[0]), 0.0, 0.0, 0.2, 0.3).is_safe
    assert course(design_of(system, law, 1 - x[0]), 0.0, 0.0, -0.2, 0.3).is_safe


def test_an_unstable_robot_settles_nowhere() -> None:
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], 9.81 * ca.sin(x[0]) + u), y=x[1])
    found = settling(design_of(system, -RATE_PER_S * x[1], 1 - x[0]))

    assert not found.may_tell
    assert found.lowest(np.zeros(4)) == -np.inf


@pytest.mark.parametrize(
    ("pull", "constant"),
    [(lambda x: 1 / x[0], 0.0), (lambda x: 1 + x[0] ** 2, 0.0), (lambda x: -5 * x[0], 1.0)],
    ids=["singular at zero", "no equilibrium", "an equilibrium for each value of a constant"],
)
def test_no_single_rest_is_no_rest(pull: Callable[[ca.SX], ca.SX], constant: float) -> None:
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], pull(x) + u, 0 * x[2]), y=x[1])

    assert not settling(design_of(system, -RATE_PER_S * x[1] - constant * x[2], 1 - x[0])).may_tell


def test_rests_side_by_side_are_left_to_the_rollout() -> None:
    """A unicycle keeps its heading: no single state to settle in where a disk is looked at, yet it stops."""
    x, u = ca.SX.sym("x", 5), ca.SX.sym("u", 2)
    f = ca.vertcat(x[3] * ca.cos(x[2]), x[3] * ca.sin(x[2]), x[4], u)
    design = design_of(System(x=x, u=u, f=f, y=x[3:]), -RATE_PER_S * x[3:], 4 - ca.sumsqr(x[:2]))

    assert settling(design).lowest(np.array([0.0, 0.0, 0.3, 1e-6, 0.0, 0.0, 0.0, 0.0])) == -np.inf
    assert course(design, 0.0, 0.0, 0.3, 1.0, 2.0).is_safe


def test_one_branch_of_a_maximum_is_enough() -> None:
    """The puck slides away along x₀ and is braked across; a minimum needs both."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    system = System(x=x, u=u, f=ca.vertcat(x[2], x[3], u), y=x[2:])
    law = ca.vertcat(0, -RATE_PER_S * x[3])

    assert course(design_of(system, law, ca.fmax(x[0], 0.5 - x[1])), 1.0, 3.0, 0.1, 0.0).is_safe
    assert not course(design_of(system, law, ca.fmin(x[0], 0.5 - x[1])), 1.0, 0.0, -0.1, 0.0).is_safe


@pytest.mark.parametrize("seed", range(4))
def test_bound_holds_along_a_long_rollout(seed: int) -> None:
    """Pendulums with random damping, law and state: no sample of 10 s is below the bound, wherever one is given."""
    rng = np.random.default_rng(seed)
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    damping, stiffness = rng.uniform(0.1, 3.0), rng.uniform(0.5, 9.0)
    f = ca.vertcat(x[1], -stiffness * ca.sin(x[0]) - damping * x[1] + u, x[1] - 0.5 * x[2])
    h = rng.uniform(0.2, 1.5) - ca.dot(ca.DM(rng.normal(size=3)), x)
    law, bound = -rng.uniform(0, 3) * x[1], rng.uniform(0.5, 5.0)
    design = design_of(System(x=x, u=u, f=f, y=x[1]), law, h, degree=1, bound=bound)
    given, judge, evaluate = 0, settling(design), ca.Function("h", [x], [h])
    step = ca.integrator("step", "rk", {"x": x, "p": u, "ode": f}, 0.0, DT_S)
    sent = ca.Function("sent", [x], [ca.fmin(ca.fmax(law, -bound), bound)])
    for start in rng.normal(scale=(0.6, 0.6, 0.3), size=(5, 3)):
        lowest = judge.lowest(np.array([*start, 0.0, float(sent(start))]))
        given += lowest > -np.inf
        state: Array = start
        heights = [float(evaluate(state))]
        for _ in range(1000):
            state = step(x0=state, p=sent(state))["xf"].full().ravel()
            heights.append(float(evaluate(state)))
        assert min(heights) >= lowest
    assert given


def test_a_map_without_a_slope_settles_nowhere() -> None:
    """The spring is √(1 + x₀) − 1, which is no number where x₀ < −1, nor halfway from −3 to its rest."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], 1 - ca.sqrt(1 + x[0]) + u), y=x[1])
    found = settling(design_of(system, -RATE_PER_S * x[1], 30 - x[0]))

    assert found.lowest(np.array([-0.1, 0.0, 0.0, 0.0])) > 0
    assert found.lowest(np.array([-3.0, 0.0, 0.0, 0.0])) == -np.inf


@pytest.mark.parametrize("distance", [0.1, 1.0, 10.0])
def test_what_may_be_kept_is_known_without_slopes(distance: float) -> None:
    """A linear map is nowhere steeper than at rest: both judge alike. A saturated law brakes less than it promises."""
    near, far = settling(point(wall=distance)), settling(saturated(wall=distance))
    speeds = np.linspace(-3.0, 3.0, 61)
    states = [np.array([0.0, v, 0.0, -RATE_PER_S * v]) for v in speeds]

    assert [near.may_keep(state) for state in states] == [near.lowest(state) >= 0 for state in states]
    assert all(far.may_keep(state) for state in states if far.lowest(state) >= 0)
    assert sum(far.may_keep(state) for state in states) >= sum(far.lowest(state) >= 0 for state in states)
