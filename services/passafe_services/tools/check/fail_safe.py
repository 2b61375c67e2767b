"""Check that the plant's fail-safe, held over its period and within the input's limits, keeps each barrier."""

from collections.abc import Iterator
from typing import Final

import casadi as ca
import numpy as np

from passafe.barrier_chain import Barrier
from passafe.design import FilterDesign
from passafe.finding import Finding, Severity
from passafe.models.robot import NOT_STATED, Robot
from passafe_services.scenarios.design import barriers_of
from passafe_services.scenarios.schema import Scenario

TOPIC: Final = "fail-safe"
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
    bend, _ = ca.hessian(h, robot.system.x)
    k = robot.position.numel()
    evaluate = ca.Function("bend", [robot.system.x, robot.system.t], [ca.densify(bend[:k, :k])])
    states = np.random.default_rng(1).normal(size=(16, robot.system.n))
    bends = (evaluate(x, 0.0).full() for x in states)
    return any(np.isfinite(b).all() and np.linalg.eigvalsh(b)[0] < -CURVED for b in bends)


def _within_limits(scenario: Scenario, robot: Robot, design: FilterDesign) -> Finding:
    """Compare what the law asks for at the largest speeds of the box of starts with the limits of the input."""
    speed = _largest_speed(scenario, robot)
    x = np.zeros(robot.system.n)
    velocity = slice(robot.position.numel(), robot.position.numel() + robot.velocity.numel())
    law = ca.Function("law", [robot.system.x], [robot.fail_safe])
    asked = 0.0
    for sign in (-1.0, 1.0):
        x[velocity] = sign * speed
        asked = max(asked, float(np.abs(law(x).full()).max()))
    most = float(min(min(abs(low), abs(high)) for low, high in zip(design.limits.low, design.limits.high, strict=True)))
    top = robot.fail_safe_scope.top_speed
    found = f"at {speed:.3g} on every axis it asks for {asked:.3g} of {most:.3g}"
    if asked <= most and speed <= top:
        return _note("limits of the input", found)
    return Finding(
        severity=Severity.WARNING,
        topic=TOPIC,
        subject="limits of the input",
        found=found + (f"; it is proven up to a speed of {top:.3g}" if speed > top else ""),
        advice="wider limits, lower gains, or a speed-limit barrier: at such a speed it stops too late",
    )


def _largest_speed(scenario: Scenario, robot: Robot) -> float:
    """Return the largest component of the velocity that starts have and a speed limit allows."""
    first = robot.position.numel()
    plant = scenario.plant
    corners = [corner for corner in (plant.x0, plant.start_low, plant.start_high) if corner is not None]
    fastest = max(abs(value) for corner in corners for value in corner[first : first + robot.velocity.numel()])
    limits = (getattr(barrier, "limit_m_per_s", None) for barrier in scenario.barriers)
    return float(max([fastest, *(limit for limit in limits if limit is not None)]))


def _note(subject: str, found: str) -> Finding:
    return Finding(severity=Severity.NOTE, topic=TOPIC, subject=subject, found=found)
