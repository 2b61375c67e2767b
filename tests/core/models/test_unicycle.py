"""The unicycle driven by its nose, against closed forms (``passafe.models.unicycle``)."""

from math import cos, sin

import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric

from passafe import (
    Barrier,
    ErrorGrowth,
    FilterDesign,
    Passivity,
    SafetyPassivityFilter,
    Status,
    Uncertainty,
    power_margin,
    unicycle,
)
from passafe.errors import DesignError
from passafe.sampled_plant import SampledPlant

D, NOSE = 0.7, 0.4
ROBOT = unicycle(drag=D, nose_m=NOSE, brake_per_s=4.0)
AT = [0.3, -0.2, 0.9, 1.1, -0.8]


def test_nose_obeys_the_stated_acceleration() -> None:
    """q̈ = R(θ)(u₁ − dv − ℓω², ℓ(u₂ − dω) + vω)."""
    x, u, (_, _, theta, v, turn) = AT, [0.6, -1.3], AT
    forward, left = np.array([cos(theta), sin(theta)]), np.array([-sin(theta), cos(theta)])
    system = ROBOT.system
    acceleration = numeric([system.x, system.u], system.lie_derivative(ROBOT.velocity))(x, u)

    expected = forward * (u[0] - D * v - NOSE * turn**2) + left * (NOSE * (u[1] - D * turn) + v * turn)
    assert acceleration.ravel() == pytest.approx(expected)


def test_commanded_nose_is_a_damped_point() -> None:
    """Under feedback and a force w on the nose: q̈ = w − dq̇."""
    system, task = ROBOT.system, ROBOT.task
    assert task is not None
    assert ROBOT.feedback is not None
    driven = ca.substitute(system.lie_derivative(ROBOT.velocity), system.u, ROBOT.feedback + task.u_h)
    w, (velocity,) = [0.5, 2.0], [numeric([system.x], ROBOT.velocity)(AT).ravel()]

    assert numeric([system.x, task.command], driven)(AT, w).ravel() == pytest.approx(np.array(w) - D * velocity)


def test_fail_safe_stops_the_nose_on_a_straight_segment() -> None:
    """Followed at every instant q moves to q + q̇/κ; held for 1 ms each it ends within 2 mm of it."""
    system = ROBOT.system
    plant = SampledPlant(system, ca.SX(0), 1e-3)
    law = ca.Function("law", [system.x], [ROBOT.fail_safe])
    place = ca.Function("place", [system.x], [ROBOT.position, ca.vertcat(*ROBOT.stopping_hull)])
    start, hull = (part.full().ravel() for part in place(AT))
    end, line, sample = hull[2:], hull[2:] - start, plant.at(tuple(AT))
    furthest = 0.0
    for _ in range(2_000):
        sample = plant.advance(sample.x, tuple(law(list(sample.x)).full().ravel()))
        q = place(list(sample.x))[0].full().ravel() - start
        furthest = max(furthest, abs(q[0] * line[1] - q[1] * line[0]) / float(np.hypot(*line)))

    assert furthest < 2e-3
    assert place(list(sample.x))[0].full().ravel() == pytest.approx(end, abs=2e-3)


def test_power_margin_is_the_drag_of_both_speeds() -> None:
    """V̇ = yᵀu − 2dV, and the feedback supplies nothing."""
    system, storage = ROBOT.system, ROBOT.storage
    assert storage is not None
    assert ROBOT.feedback is not None
    margin = power_margin(system, Passivity(V=storage).V)
    energy = numeric([system.x], storage)(AT).item()

    assert numeric([system.x, system.u], margin)(AT, [0.6, -1.3]).item() == pytest.approx(2 * D * energy)
    supplied = ca.substitute(system.power, system.u, ROBOT.feedback)
    assert numeric([system.x], supplied)(AT).item() == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("name", ["drag", "nose_m", "brake_per_s"])
def test_numbers_that_make_no_car_are_refused(name: str) -> None:
    with pytest.raises(DesignError, match=f"unicycle {name}"):
        unicycle(**{name: 0.0})


def level_design(**parts: object) -> FilterDesign:
    h = ca.sumsqr(ROBOT.position - ca.DM([2.0, 1.1])) - 0.8**2
    return FilterDesign(
        system=ROBOT.system,
        u_fb=ROBOT.feedback,
        fail_safe=ROBOT.fail_safe,
        barriers=(Barrier(name="post", h=h, class_k=(3.0, 3.0, 20.0)),),
        passivity=Passivity(V=ROBOT.storage),
        k_i=50.0,
        dt_s=2e-3,
        hold_s=1e-2,
        input_bound=30.0,
        **parts,
    )


def test_car_at_rest_along_an_axis_needs_no_fallback() -> None:
    """Its sideways place rests at x, but not in the tube: a first guess of that is too narrow."""
    decision = SafetyPassivityFilter(level_design()).decide(
        [0.0] * 5, [0.0, 0.0], [3.0, 3.0], [0.0, 0.0], 1.0, start=True
    )

    assert decision.status in {Status.PASSED, Status.MODIFIED, Status.RELAXED}


def test_error_of_a_car_at_rest_along_an_axis_is_bounded() -> None:
    growth = ErrorGrowth(level_design(uncertainty=Uncertainty(parameters={"drag": (0.5, 0.9)})))

    after = growth.advance([0.0] * 5, (3.0, 3.0), (0.0,) * 5)
    assert max(after) < 1e-4
    assert after[3] > 0.0
