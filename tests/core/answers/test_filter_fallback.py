"""Fallbacks: INFEASIBLE and UNCERTIFIED reached by real designs, and the fail-safe that follows."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import assert_consistent, gains, paper_design, pump_design, random_state
from finite_differences import Array, numeric

from passafe.barrier_chain import Barrier
from passafe.barriers import half_plane
from passafe.certificate import Tolerance
from passafe.decision import Status
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.program.solvers.daqp_solver import DaqpSolver
from passafe.program.solvers.least_distance_solver import LeastDistanceSolver
from passafe.program.solvers.least_violation import LeastViolationSolver
from passafe.program.solvers.piqp_solver import PiqpSolver
from passafe.program.solvers.solver import SolverOutcome
from passafe.system import System

ZERO = (0.0, 0.0)


def channel(left: float, right: float, **changes: object) -> SafetyPassivityFilter:
    """Return a filter that keeps the paper's robot between two walls, with γ₁ = γ₂ = 10·s."""
    design = paper_design(mode=Mode.SAFE)
    position = design.system.x[:2]
    walls = (("left", (1.0, 0.0), left), ("right", (-1.0, 0.0), -right))
    barriers = tuple(
        Barrier(name=name, h=half_plane(position, normal=n, offset=o), class_k=gains(10.0, 10.0, 10.0))
        for name, n, o in walls
    )
    return SafetyPassivityFilter(replace(design, barriers=barriers, **changes))  # type: ignore[arg-type]  # by name


def fail_safe(x: Sequence[float], bound: float) -> Array:
    """−K x₂ with K = γ₁ − σ = 9, within the bound."""
    return np.clip(-9.0 * np.asarray(x[2:]), -bound, bound)


@pytest.mark.parametrize("law", Law)
def test_conflicting_walls_are_infeasible_and_share_violation(law: Law) -> None:
    """−1·u₀ and +1·u₀ cannot both be at least c: the least squares of what is missing shares it."""
    made = channel(left=1.0, right=-1.0, law=law, between_samples=False)
    x = (0.0, 0.0, 0.0, -20.0)
    decision = made.decide(x, (1.0, 1.0), ZERO, ZERO)

    assert decision.status is Status.INFEASIBLE
    assert decision.part("conflict")[0] > 0
    assert decision.margins[:2] == pytest.approx([decision.margins[0]] * 2)
    assert decision.margins[:2] == pytest.approx(-decision.part("relax"), rel=1e-6)
    assert decision.margins.min() < -0.1  # the evidence shows what is not kept
    assert_consistent(made, decision)


def test_walls_that_leave_room_are_not_infeasible() -> None:
    decision = channel(left=-1.0, right=1.0).decide((0.0, 0.0, 0.5, -20.0), (1.0, 1.0), ZERO, ZERO)

    assert decision.status is Status.PASSED


def test_bound_too_small_for_the_rows_is_infeasible_and_reached() -> None:
    x = (-0.99, 0.0, -5.0, 1.0)  # 5 m/s into a wall 1 cm away needs ψ₂ = u + 5 − 100 + 1 ≥ 0: u ≥ 94
    enough = channel(-1.0, 9.0, input_bound=95.0, between_samples=False)
    too_little = channel(-1.0, 9.0, input_bound=40.0)

    assert enough.decide(x, ZERO, ZERO, ZERO).status is Status.MODIFIED
    decision = too_little.decide(x, ZERO, ZERO, ZERO)
    assert decision.status is Status.INFEASIBLE
    assert decision.u[0] == pytest.approx(40.0, abs=1e-4)
    assert decision.u[1] == pytest.approx(decision.part("u_ref")[1], abs=1e-6)  # the other axis is the operator's
    assert_consistent(too_little, decision)


@pytest.mark.parametrize("tolerance", [Tolerance(residual=1e-17), Tolerance(gap=1e-17)])
def test_next_solver_is_asked_after_a_failed_certificate(tolerance: Tolerance) -> None:
    """An interior-point method is never exact to the last bit; the active-set method is, on one row."""
    decision = channel(-1.0, 9.0, tolerance=tolerance).decide((-0.99, 0.0, -5.0, 1.0), (1.0, 1.0), ZERO, ZERO)

    assert (decision.status, decision.solver) == (Status.MODIFIED, "daqp")


@pytest.mark.parametrize("tolerance", [Tolerance(residual=-1.0), Tolerance(gap=-1.0)])
def test_an_answer_that_fails_the_certificate_is_not_used(tolerance: Tolerance) -> None:
    x = (-0.99, 0.0, -5.0, 1.0)
    made = channel(-1.0, 9.0, tolerance=tolerance)
    decision = made.decide(x, (1.0, 1.0), ZERO, ZERO)

    assert decision.status is Status.UNCERTIFIED
    assert decision.solver == "backup"  # nobody's answer is used
    assert decision.u == tuple(fail_safe(x, 100.0))
    assert_consistent(made, decision)


def integrator(h: Callable[[ca.SX], ca.SX], u_fb: Callable[[ca.SX], ca.SX], mode: Mode) -> SafetyPassivityFilter:
    """Return a filter for ẋ = u with one state, bound 10."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=u, y=x),
        u_fb=u_fb(x),
        fail_safe=ca.SX(0.0),
        barriers=(Barrier(name="domain", h=h(x), class_k=gains(1.0, 1.0)),),
        passivity=Passivity(V=x**2 / 2),
        k_i=1.0,
        dt_s=0.1,
        input_bound=10.0,
        mode=mode,
    )
    return SafetyPassivityFilter(design)


@pytest.mark.parametrize("outside", [-1.0, 0.0, -0.0])
def test_a_row_that_is_no_number_is_not_certified(outside: float) -> None:
    """Outside the domain of h = log(x) nobody can say that the row is kept."""
    made = integrator(ca.log, lambda x: 0 * x, Mode.SAFE)

    assert made.decide((2.0,), (0.0,), (0.0,), (0.0,)).status is Status.PASSED
    decision = made.decide((outside,), (0.0,), (0.0,), (0.0,))
    assert decision.status.is_fallback, decision.psi


@pytest.mark.parametrize("mode", [Mode.OFF, Mode.SAFE])
def test_a_nominal_input_that_is_no_number_is_not_certified(mode: Mode) -> None:
    """Outside the domain of u_fb = √x there is nothing to follow: not the bound either."""
    made = integrator(lambda x: x + 5, lambda x: -ca.sqrt(x), mode)

    assert made.decide((4.0,), (0.0,), (0.0,), (0.0,)).status is Status.PASSED
    decision = made.decide((-1.0,), (0.0,), (0.0,), (0.0,))
    assert decision.status.is_fallback, decision.u
    assert decision.u == (0.0,)


def test_rows_that_nobody_can_say_how_to_relax_are_not_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    made = channel(left=1.0, right=-1.0)
    request = ((0.0, 0.0, 0.5, -20.0), (1.0, 1.0), ZERO, ZERO)
    assert made.decide(*request).status is Status.INFEASIBLE
    monkeypatch.setattr(LeastViolationSolver, "solve", lambda *_: None)

    assert made.decide(*request).status is Status.UNCERTIFIED


def test_a_proven_conflict_needs_no_slow_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    made = channel(left=1.0, right=-1.0)

    def must_not(*_: object) -> SolverOutcome:
        raise AssertionError

    monkeypatch.setattr(LeastDistanceSolver, "solve", must_not)

    assert made.decide((0.0, 0.0, 0.5, -20.0), (1.0, 1.0), ZERO, ZERO).status is Status.INFEASIBLE


def test_a_conflict_that_is_not_proven_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 0.5 m before the left wall at −4 m/s both inputs need the limits, and an answer exists."""
    made = channel(left=-1.0, right=1.0)
    request = ((-0.5, 0.0, -4.0, 0.0), (0.0, 0.0), ZERO, ZERO)
    expected = made.decide(*request)
    assert expected.solver == "piqp"
    for kind in (PiqpSolver, DaqpSolver):
        monkeypatch.setattr(kind, "solve", lambda *_: SolverOutcome.INFEASIBLE)
    decision = made.decide(*request)

    assert (decision.status, decision.solver) == (expected.status, "ldp")
    assert decision.u == pytest.approx(expected.u, abs=1e-6)


def above_floor(rate: Callable[[ca.SX], ca.SX], gain: float, **changes: object) -> SafetyPassivityFilter:
    """Return a filter that keeps x ≥ 0 for a plant ẋ = rate(u), with γ = gain·s."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=rate(u), y=x),
        u_fb=ca.SX(0),
        fail_safe=ca.SX(0),
        barriers=(Barrier(name="floor", h=x, class_k=gains(gain, gain)),),
        passivity=Passivity(V=x**2),
        k_i=5.0,
        dt_s=5e-3,
        input_bound=4.0,
        mode=Mode.SAFE,
    )
    return SafetyPassivityFilter(replace(design, **changes))  # type: ignore[arg-type]  # by name


def test_tangent_that_misses_is_tightened_by_twice_the_shortfall() -> None:
    """ẋ = u − u²/10 at x = 1/2: the tangent at 0 gives u = −1, which misses u − u²/10 + 1 ≥ 0 by 1/12."""
    made = above_floor(lambda u: u - u**2 / 10, 2.0, between_samples=False)
    decision = made.decide((0.5,), (0.0,), (-3.0,), (0.0,), start=True)

    assert decision.status is Status.MODIFIED
    assert decision.u == pytest.approx((-1 + 1 / 12 + 2 * (1 / 12 - 1e-5),), abs=1e-7)


def test_tangent_that_leads_to_a_conflict_goes_half_way_back() -> None:
    """A wing that lifts at angles about 2 alone: the tangent at 0.8 leads to 3.7, the one there beyond all."""
    made = above_floor(lambda u: ca.exp(-2 * (u - 2) ** 2) - 0.9, 1.0, input_bound=8.0)
    decision = made.decide((0.05,), (0.8,), (0.8,), (0.0,), start=True)

    assert decision.status is Status.MODIFIED
    assert np.exp(-2 * (decision.u[0] - 2) ** 2) - 0.9 + 0.05 >= 0.0
    assert decision.u[0] == pytest.approx(2 - np.sqrt(-np.log(0.85) / 2), abs=0.05)


def test_without_margins_tangents_follow_a_row_not_affine_in_u() -> None:
    made = SafetyPassivityFilter(pump_design(between_samples=False, mode=Mode.SAFE))
    held = numeric([made.design.system.x, made.design.system.u], made.chains[0].psi[1])
    rng = np.random.default_rng(83)
    modified = 0
    for _ in range(300):
        x, u = random_state(rng, 2), random_state(rng, 2)
        decision = made.decide(list(x), list(u), list(6 * random_state(rng, 2)), ZERO)
        if decision.status is Status.MODIFIED:
            modified += 1
            assert held(x, np.array(decision.u))[0] >= -1e-3
    assert modified > 20
