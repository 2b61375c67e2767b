"""Closed-form bounds of derivatives: of rotated vectors, and in the margin between samples."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from passafe import (
    Barrier,
    DesignError,
    FilterDesign,
    Passivity,
    SafetyPassivityFilter,
    SampledPlant,
    Status,
    System,
    Tank,
    power_margin,
)
from passafe.barriers.spheres import BoundedFunction, above_level, ball_keep_out, spheres_apart
from passafe.class_k import Cubic
from passafe.models.robot import Robot
from passafe.models.seven_joint_arm import TOP_ACCELERATION, seven_joint_arm

ARM = seven_joint_arm(sigma=1.0, gamma_1=8.0, dt_s=1e-3)
SPHERES = {sphere.name: sphere for sphere in ARM.spheres}
HELD_S = 4e-3
FUNCTIONS = {
    "ball": ball_keep_out(SPHERES["tip"], centre=(0.5, 0.2, 0.4), radius=0.1),
    "level": above_level(SPHERES["forearm 2"], height=0.1),
    "apart": spheres_apart(SPHERES["upper arm 1"], SPHERES["tip"]),
}


def derivatives(system: System, h: ca.SX) -> list[ca.SX]:
    found = []
    for _ in range(4):
        h = system.rate(h)
        found.append(h)
    return found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_derivatives_stay_within_their_bounds(name: str) -> None:
    system, function = ARM.system, FUNCTIONS[name]
    bounds = function.bounds
    true = ca.Function("true", [system.x, system.u], derivatives(system, function.h))
    bound = ca.Function("bound", [system.x, bounds.x_size, bounds.u_size, bounds.held_s], [bounds.orders])
    plant, rng = SampledPlant(system, ARM.storage, HELD_S / 4), np.random.default_rng(3)
    for _ in range(40):
        x = np.concatenate((rng.uniform(-2.5, 2.5, 7), rng.uniform(-2.0, 2.0, 7)))
        u = rng.uniform(-1.0, 1.0, 7) * TOP_ACCELERATION
        course = [tuple(x)]
        for _ in range(4):
            course.append(plant.advance(course[-1], tuple(u)).x)
        most = np.abs([[float(each) for each in true(state, u)] for state in course]).max(axis=0)
        allowed = np.array(bound(x, np.abs(course).max(axis=0), np.abs(u), HELD_S)).ravel()
        assert (most <= allowed).all()


def test_the_power_margin_stays_within_its_bounds() -> None:
    system, bounds = ARM.system, ARM.power_bounds
    assert ARM.storage is not None
    assert bounds is not None
    margin = power_margin(system, ARM.storage)
    true = ca.Function("true", [system.x, system.u], derivatives(system, margin)[:2])
    bound = ca.Function("bound", [bounds.x_size, bounds.u_size], [bounds.orders])
    rng = np.random.default_rng(5)
    for _ in range(200):
        x, u = rng.uniform(-2.0, 2.0, 14), rng.uniform(-1.0, 1.0, 7) * TOP_ACCELERATION
        found = np.abs([float(each) for each in true(x, u)])
        assert (found <= np.array(bound(np.abs(x), np.abs(u))).ravel()).all()


def test_the_tank_holds_between_samples() -> None:
    tank = Tank(initial_j=2.0, reserve_j=0.5, max_j=10.0, rate_per_s=5.0)
    passivity = Passivity(V=ARM.storage, tank=tank, derivative_bounds=ARM.power_bounds)
    made = SafetyPassivityFilter(replace(small_design(FUNCTIONS["ball"]), passivity=passivity, mode="both"))

    decision = made.decide((0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.8, *(0.5,) * 7), (0.0,) * 7, (1.0,) * 7, (0.0,) * 7, 2.0)

    assert decision.status in {Status.PASSED, Status.MODIFIED}


def small_design(function: BoundedFunction, robot: Robot = ARM, **changes: object) -> FilterDesign:
    barrier = Barrier(name="ball", h=function.h, class_k=(8.0, 8.0, 100.0), derivative_bounds=function.bounds)
    return FilterDesign(
        system=robot.system,
        u_fb=-2 * robot.velocity,
        fail_safe=robot.fail_safe,
        barriers=(replace(barrier, **changes),),
        passivity=Passivity(V=robot.storage),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=TOP_ACCELERATION,
        hold_s=HELD_S,
        mode="safe",
    )


def test_a_pushed_sphere_stops_at_the_ball() -> None:
    sphere = SPHERES["tip"]
    start = (0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.8)
    place = ca.Function("place", [ARM.system.x], [sphere.centre])
    tip = np.array(place((*start, *(0.0,) * 7))).ravel()
    function = ball_keep_out(sphere, centre=tip - [0.0, 0.0, 0.2], radius=0.06)
    made = SafetyPassivityFilter(small_design(function))
    plant = SampledPlant(ARM.system, ARM.storage, 1e-3)
    slope = ca.Function("slope", [ARM.system.x], [ca.gradient(function.h, ARM.position), function.h])
    x, u, lowest = (*start, *(0.0,) * 7), (0.0,) * 7, np.inf
    for _ in range(1500):
        towards, h = slope(x)
        lowest = min(lowest, float(h))
        pushed = np.clip(-40.0 * np.array(towards[:7]).ravel(), -5.0, 5.0)
        u = made.decide(x, u, tuple(pushed.tolist()), (0.0,) * 7).u
        x = plant.advance(x, u).x

    assert 0.0 <= lowest < 2e-3  # stands off by less than 5 mm: h is about 0.23 m times the distance


def test_bounds_of_other_forms_are_refused() -> None:
    function = FUNCTIONS["ball"]
    few = replace(function.bounds, orders=function.bounds.orders[:3])
    with pytest.raises(DesignError, match="3 derivatives, allowed 4, two more than its relative degree"):
        SafetyPassivityFilter(small_design(function, derivative_bounds=few))
    with pytest.raises(DesignError, match="linear ones, where derivative bounds are given"):
        SafetyPassivityFilter(small_design(function, class_k=(Cubic(gain=8.0), 8.0, 100.0)))
    two = ca.fmin(function.h, FUNCTIONS["level"].h)
    with pytest.raises(DesignError, match="a minimum or maximum of several parts"):
        SafetyPassivityFilter(small_design(function._replace(h=two)))
