"""Check that the plant's fail-safe, held over its period and within the input's limits, keeps each barrier."""

from collections.abc import Iterator
from math import isfinite
from typing import Final, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.barrier_chain import Barrier
from passafe.design import FilterDesign
from passafe.finding import Finding, Severity
from passafe.models.robot import NOT_STATED, Robot
from passafe_services.scenarios.design import barriers_of
from passafe_services.scenarios.schema import Scenario

FloatArray: TypeAlias = NDArray[np.float64]

TOPIC: Final = "fail-safe"
ROUNDING: Final = 1e-9
CURVED: Final = 1e-9
"""Curvature of h along the position below which it counts as none, in h's own units."""


def fail_safe_findings(scenario: Scenario, robot: Robot, design: FilterDesign) -> Iterator[Finding]:
    """Yield a finding for each barrier of the position, one for the law's strength."""
    barriers = zip(scenario.barriers, barriers_of(scenario, robot), strict=True)
    if robot.fail_safe_condition == NOT_STATED:
        yield _not_stated()
        return
    yield from (_kept(robot, barrier) for config, barrier in barriers if config.is_of_position)
    yield _note("law", robot.fail_safe_condition)
    yield _within_limits(scenario, robot, design)


def _not_stated() -> Finding:
    return Finding(
        severity=Severity.WARNING,
        topic=TOPIC,
        subject="law",
        found=NOT_STATED,
        advice="give the robot a fail_safe_scope and a fail_safe_condition; until then, when inputs stop, h may become "
        "negative",
    )


def _kept(robot: Robot, barrier: Barrier) -> Finding:
    subject, scope = f"barrier {barrier.name!r}", robot.fail_safe_scope
    if ca.depends_on(barrier.h, robot.system.t):
        return _note(subject, "it moves by itself: braking does not keep it")
    if _curves_inwards(robot, barrier.h):
        return _note(subject, "a set to stay in: kept from where position + velocity/κ is in it, not from all ψ ≥ 0")
    if scope.keeps(barrier.class_k):
        return _note(subject, "its gains are kept, under the condition of the law")
    gains = ", ".join(f"{gamma.gain:g}" for gamma in barrier.class_k[: len(scope.kept_gains)])
    kept = ", ".join(f"{gain:.4g}" for gain in scope.kept_gains)
    return Finding(
        severity=Severity.WARNING,
        topic=TOPIC,
        subject=subject,
        found=f"gains {gains} 1/s: with inputs held for {scope.dt_s:.4g} s linear ones up to {kept} 1/s are kept",
        advice="lower these gains, make them linear, or raise rate_hz: when inputs stop, h may become negative",
    )


def _curves_inwards(robot: Robot, h: ca.SX) -> bool:
    """Return whether h curves down somewhere along the position: its set then is one to stay in."""
    system = robot.system
    states = [state for state in ca.vertsplit(system.x) if ca.depends_on(robot.position, state)]
    bend, _ = ca.hessian(h, ca.vertcat(*states))
    evaluate = ca.Function("bend", [system.x, system.t], [ca.densify(bend)])
    bends = (evaluate(x, 0.0).full() for x in np.random.default_rng(1).normal(size=(16, system.n)))
    return any(np.isfinite(b).all() and np.linalg.eigvalsh(b)[0] < -CURVED for b in bends)


def _within_limits(scenario: Scenario, robot: Robot, design: FilterDesign) -> Finding:
    """Compare what the law asks for at the largest speeds of the box of starts with the limits of the input."""
    speed = _largest_speed(scenario, robot)
    law = ca.Function("law", [robot.system.x], [ca.densify(robot.fail_safe)])
    asked = np.array([law(x).full().ravel() + 0.0 for x in _at_speed(scenario, robot, speed)])
    low, high = np.asarray(design.limits.low), np.asarray(design.limits.high)
    axis = int(np.argmax(np.maximum(asked - high, low - asked).max(axis=0)))  # that comes nearest to its limits
    least, most = float(asked[:, axis].min()), float(asked[:, axis].max())
    top = robot.fail_safe_scope.top_speed
    if least == -most and low[axis] == -high[axis]:
        found = f"at {speed:.3g} on every axis it asks for {most:.3g} of {high[axis]:.3g}"
    else:
        found = f"at {speed:.3g} on every axis it asks for {least:.3g} to {most:.3g} of input {axis + 1}"
        found += f", which has {low[axis]:.3g} to {high[axis]:.3g}"
    slack = ROUNDING * (high[axis] - low[axis])
    if low[axis] - slack <= least and most <= high[axis] + slack and speed <= top:
        return _note("limits of the input", found)
    return Finding(
        severity=Severity.WARNING,
        topic=TOPIC,
        subject="limits of the input",
        found=found + (f"; it is proven up to a speed of {top:.3g}" if speed > top else ""),
        advice="wider limits, lower gains, or a speed-limit barrier: at such a speed it stops too late",
    )


def _at_speed(scenario: Scenario, robot: Robot, speed: float) -> Iterator[FloatArray]:
    """Yield the states beside x0 in which every coordinate of the velocity is ±speed, to first order."""
    x0 = np.asarray(scenario.plant.x0, dtype=float)
    if not robot.velocity.numel():
        yield x0
        return
    x = robot.system.x
    moves = ca.Function("moves", [x], [ca.densify(robot.velocity), ca.densify(ca.jacobian(robot.velocity, x))])
    velocity, jacobian = (part.full() for part in moves(x0))
    if not np.isfinite(velocity).all() or not np.isfinite(jacobian).all():
        yield x0
        return
    for sign in (-1.0, 1.0):
        yield x0 + np.linalg.lstsq(jacobian, sign * speed - velocity.ravel(), rcond=None)[0]


def _largest_speed(scenario: Scenario, robot: Robot) -> float:
    """Return the largest component of the velocity that starts have and a speed limit allows."""
    plant = scenario.plant
    corners = [corner for corner in (plant.x0, plant.start_low, plant.start_high) if corner is not None]
    velocity = ca.Function("velocity", [robot.system.x], [ca.densify(robot.velocity)])
    speeds = [abs(value) for corner in corners for value in velocity(list(corner)).elements() if isfinite(value)]
    limits = (getattr(barrier, "limit_m_per_s", None) for barrier in scenario.barriers)
    return float(max([0.0, *speeds, *(limit for limit in limits if limit is not None)]))


def _note(subject: str, found: str) -> Finding:
    return Finding(severity=Severity.NOTE, topic=TOPIC, subject=subject, found=found)
