"""Limits for each axis and side, polytopes and norms of parts: what is decided within them."""

from math import inf, isfinite, nan

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, drag_design, jerk_design, paper_design, row_filter, row_state
from limit_sets import LIMIT_SETS, directions, limited, random_inputs
from random_requests import requests_of
from scipy.optimize import linprog

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.batch.batch_filter import BatchFilter
from passafe.decision import Status
from passafe.design import Mode
from passafe.errors import DesignError, ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.interior_point import interior_point
from passafe.limits import Limits
from passafe.override import Explainer
from passafe.program.infeasibility import DistanceToInfeasibility
from passafe.program.solvers.least_distance_solver import LeastDistanceSolver
from passafe.program.solvers.solver import INFEASIBLE, SOLVED

HOSTILE = (nan, inf, -inf, 1e300, -1e300, 1e154, 5e-324, -0.0, 1e15)
TWO_AXES: tuple[Builder, ...] = tuple(builder for builder in DESIGNS if builder is not jerk_design)
ROUNDED = 1e-12


@requests_of(160, some=60)
@pytest.mark.parametrize("name", LIMIT_SETS)
@pytest.mark.parametrize("builder", TWO_AXES)
def test_every_decision_is_within_all_limits(builder: Builder, name: str, count: int) -> None:
    made = SafetyPassivityFilter(limited(builder(), name))
    limits, dt_s, n = made.design.limits, made.design.dt_s, made.design.system.n
    rng = np.random.default_rng(91)
    for k, u in enumerate(random_inputs(limits, count, rng)):
        numbers = np.concatenate((rng.normal(size=n) * 2, u, rng.normal(size=2) * 10 ** rng.uniform(-1, 3)))
        if k % 2:
            numbers[rng.integers(len(numbers))] = HOSTILE[k % len(HOSTILE)]
        x, before, u_h = numbers[:n], numbers[n : n + 2], numbers[n + 2 :]
        decision = made.decide(x, before, u_h, (0.0, 0.0), 1.0, start=k % 5 == 0)

        assert all(map(isfinite, decision.u))
        assert limits.excess(np.array(decision.u)) <= ROUNDED * limits.reach
        if k % 5 and np.isfinite(before).all() and limits.excess(before) <= 0:
            assert limits.excess(np.array(decision.u), before, dt_s) <= ROUNDED * limits.reach


@requests_of(150, some=60)
@pytest.mark.parametrize("name", [name for name in LIMIT_SETS if name != "everything"])
def test_answers_are_the_nearest_and_conflicts_are_real(name: str, count: int) -> None:
    """Against the whole program with the balls as polygons, by another method: what it cannot solve is infeasible."""
    made = SafetyPassivityFilter(limited(row_filter(hard=2, soft=False).design, name))
    limits = made.design.limits
    rng, seen = np.random.default_rng(92), set()
    edges, ends = directions(limits, 720)
    for _ in range(count):
        G, d = rng.normal(size=(2, 2)), rng.normal(size=2) * 10
        decision = made.decide(
            row_state([(*G[i], -d[i]) for i in range(2)]), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), start=True
        )
        length = np.linalg.norm(G, axis=1)
        rows = np.asfortranarray(np.vstack((G / length[:, None], edges)))
        bounds = np.concatenate((d / length, ends)) - rows @ decision.part("u_ref")
        z, lam = np.zeros(2), np.zeros(len(bounds))
        outcome = LeastDistanceSolver(rows, bounds).solve(z.data, lam.data)

        seen.add(decision.status)
        if outcome is SOLVED:
            near = 5e-3  # √(2·gap), and what a polygon of 720 sides is wider than a ball
            assert decision.u == pytest.approx(decision.part("u_ref") + z, abs=near)
            assert decision.status in {Status.PASSED, Status.MODIFIED}
        else:
            assert outcome is INFEASIBLE
            assert decision.status is Status.INFEASIBLE
    assert seen >= {Status.MODIFIED, Status.INFEASIBLE}


@pytest.mark.parametrize("name", LIMIT_SETS)
def test_distance_to_infeasibility_is_the_linear_programs(name: str) -> None:
    made = SafetyPassivityFilter(limited(drag_design(between_samples=False), name))
    limits, hard = made.design.limits, 2
    solver, rng = DistanceToInfeasibility(limits, hard), np.random.default_rng(93)
    edges, ends = directions(limits, 2000)
    for u in random_inputs(limits, 60, rng):
        decision = made.decide(rng.normal(size=4) * 2, u, rng.normal(size=2) * 100, (0.0, 0.0), 1.0)
        found, posed = solver.of(decision), decision.program
        if decision.status is Status.UNCERTIFIED:
            continue
        exact = linprog(
            [0.0, 0.0, -1.0],
            A_ub=np.vstack(
                (np.column_stack((-posed.G[:hard, :2], np.ones(hard))), np.column_stack((-edges, 0 * ends)))
            ),
            b_ub=np.concatenate((-posed.d[:hard], edges @ posed.u_ref - ends)),
            bounds=[*zip(posed.low - posed.u_ref, posed.high - posed.u_ref, strict=True), (None, limits.reach)],
        )
        best = float(exact.x[-1])
        assert found.lower <= best + 1e-4
        assert found.upper >= best - (2e-4 if limits.norms else 1e-6)
        assert found.upper - found.lower <= (0.1 if limits.norms else 1e-6) * limits.reach


@pytest.mark.parametrize("name", LIMIT_SETS)
def test_batches_decide_as_the_filter_does(name: str) -> None:
    core = SafetyPassivityFilter(limited(paper_design(), name))
    rng = np.random.default_rng(94)
    u = random_inputs(core.design.limits, 64, rng).T
    x, u_h = rng.normal(size=(4, 64)) * 2, rng.normal(size=(2, 64)) * 10 ** rng.uniform(-1, 3, 64)
    many = BatchFilter(core, 64)
    many.decide(x, u, u_h, 0.0, 1.0)

    for i in range(64):
        alone = core.decide(x[:, i], u[:, i], u_h[:, i], (0.0, 0.0), 1.0)
        assert alone.u == pytest.approx(many.part("u_plus")[:, i], abs=1e-4)
        assert alone.status == many.status[i]
    assert not many.scalar[:64].all()


@pytest.mark.parametrize("name", LIMIT_SETS)
def test_what_the_override_says_would_pass_does(name: str) -> None:
    core = SafetyPassivityFilter(limited(paper_design(mode=Mode.OFF), name))
    explainer, rng, fractions = Explainer(core), np.random.default_rng(95), []
    for u in random_inputs(core.design.limits, 80, rng):
        x, u_h = rng.normal(size=4) * 0.1, rng.normal(size=2) * 60
        override = explainer.override(core.decide(x, u, u_h, (0.0, 0.0)))
        if override.unavoidable:
            continue
        fractions.append(override.allowed_fraction)
        passed = core.decide(x, u, override.allowed_fraction * u_h, (0.0, 0.0))
        assert np.abs(explainer.override(passed).change).max() <= 1e-4
    assert any(0.0 < fraction < 1.0 for fraction in fractions)


def test_a_half_space_is_named_as_the_cause() -> None:
    core = SafetyPassivityFilter(limited(paper_design(mode=Mode.OFF, u_fb=(0.0, 0.0)), "a polytope"))
    decision = core.decide((0.0, 0.0, 0.0, 0.0), (0.0, 0.0), (9.0, 4.0), (0.0, 0.0), start=True)
    override = Explainer(core).override(decision)

    assert decision.u == pytest.approx((7.5, 2.5), abs=1e-4)
    assert [cause.row for cause in override.causes] == ["half-space 0"]
    assert override.allowed_fraction == pytest.approx(10 / 13, abs=1e-4)


def test_rates_hold_for_each_side() -> None:
    made = SafetyPassivityFilter(
        paper_design(mode=Mode.OFF, input_rate_low_per_s=-2000.0, input_rate_high_per_s=(500.0, 4000.0))
    )
    up = made.decide((0.0,) * 4, (0.0, 0.0), (90.0, 90.0), (0.0, 0.0))
    down = made.decide((0.0,) * 4, (0.0, 0.0), (-90.0, -90.0), (0.0, 0.0))

    assert up.u == pytest.approx((0.5, 4.0))
    assert down.u == pytest.approx((-2.0, -2.0))


def test_a_side_without_a_rate_has_none() -> None:
    limits = Limits.of(2, 8.0, rate_high_per_s=3.0)
    low, high = (part.full().ravel().tolist() for part in map(ca.DM, limits.interval(ca.SX([1.0, 2.0]), 0.5)))

    assert (low, high) == ([-8.0, -8.0], [2.5, 3.5])
    assert limits.fall_per_s == (inf, inf)
    assert limits.excess(np.array([-7.0, 3.5]), np.array([1.0, 2.0]), 0.5) <= 0


def test_the_excess_is_that_of_the_limit_missed_most() -> None:
    limits = limited(paper_design(), "everything").limits
    inside, before = np.array([[0.0, 1.0], [0.0, 1.0]]), np.array([[0.0, 0.0], [0.0, 0.0]])

    assert (limits.excess(inside) < 0).all()
    assert limits.excess(inside, before, 1e-4).tolist() == pytest.approx([-0.08, 0.85])
    assert limits.excess(np.array([-7.5, 0.0])) == pytest.approx(1.5)
    assert limits.excess(np.array([8.0, 8.5])) == pytest.approx(12.25 / 1.25**0.5 - 8 / 1.25**0.5)
    assert limits.excess(np.array([-6.0, 1e300])) > 1e299


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"input_bound": None}, "input_bound: got None"),
        ({"input_bound": None, "input_low": -1.0}, "input_bound: got None"),
        ({"input_low": 100.0}, "every high above its low"),
        ({"input_low": (0.0, 5.0), "input_high": (1.0, 5.0)}, "every high above its low"),
        ({"input_low": nan}, "every high above its low"),
        ({"input_high": inf}, "every high above its low"),
        ({"input_low": (0.0,)}, "input_low: got 1 numbers, allowed one number, or 2"),
        ({"input_high": (1.0, 2.0, 3.0)}, "input_high: got 3 numbers"),
        ({"input_rate_low_per_s": 0.0}, "allowed negative and positive"),
        ({"input_rate_high_per_s": (1.0, -1.0)}, "allowed negative and positive"),
        ({"input_rate_high_per_s": nan}, "allowed negative and positive"),
        ({"input_norms": NormBound(axes=(0,), bound=1.0)}, "input_norms: got .*, allowed a sequence of NormBound"),
        ({"input_norms": [5.0]}, "input_norms: got .*, allowed a sequence of NormBound"),
        ({"input_half_spaces": [(1.0, 2.0)]}, "input_half_spaces: got .*, allowed a sequence of HalfSpace"),
        (
            {"input_norms": (NormBound(axes=(0, 2), bound=1.0),)},
            r"norm axes: got \[0, 2\], allowed numbers below 2",
        ),
        (
            {"input_half_spaces": (HalfSpace(weights=(1.0,), bound=1.0),)},
            "weights: got 1 numbers, allowed 2",
        ),
        ({"input_half_spaces": (HalfSpace(weights=(1.0, 0.0), bound=-100.0),)}, "without an interior"),
        (
            {"input_norms": (NormBound(axes=(0, 1), bound=3.0),), "input_low": (4.0, -1.0)},
            "input limits: got a set of inputs without an interior",
        ),
    ],
)
def test_limits_that_leave_nothing_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        paper_design(**changes)


@pytest.mark.parametrize("axes", [(), (0, 0), (-1,), (0.5,), "01", None])
def test_norms_need_axes(axes: object) -> None:
    with pytest.raises(DesignError, match="input norm axes"):
        NormBound(axes=axes, bound=1.0)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(DesignError, match="input norm bound"):
        NormBound(axes=(0,), bound=0.0)
    with pytest.raises(DesignError, match=r"input norm bound: got 1e\+160, allowed at most 1e\+100"):
        NormBound(axes=(0,), bound=1e160)


@pytest.mark.parametrize(
    ("weights", "bound"),
    [((), 1.0), ((0.0, 0.0), 1.0), ((nan, 1.0), 1.0), ((1.0, 1.0), inf), ((1.0, 1.0), 1e160), ((1e-90,), 1e20)],
)
def test_half_spaces_need_weights(weights: tuple[float, ...], bound: float) -> None:
    with pytest.raises(DesignError, match="input half-space"):
        HalfSpace(weights=weights, bound=bound)
    with pytest.raises(ShapeError):
        HalfSpace(weights=("a", "b"), bound=1.0)  # type: ignore[arg-type]  # wrong on purpose


def test_half_spaces_are_scaled_to_unit_length() -> None:
    half_space = HalfSpace(weights=[3, 4], bound=10)  # type: ignore[arg-type]  # a list

    assert (half_space.weights, half_space.bound) == ((0.6, 0.8), 2.0)


def test_the_centre_is_inside_also_where_there_is_little_room() -> None:
    for name in LIMIT_SETS:
        limits = limited(paper_design(), name).limits
        assert limits.excess(np.array(limits.centre)) < 0
    thin = (HalfSpace(weights=(1.0, 1.0), bound=1e-3), HalfSpace(weights=(-1.0, -1.0), bound=1e-3))
    corner = (HalfSpace(weights=(-1.0, -1.0), bound=-1.99),)
    assert interior_point((-1.0, -1.0), (1.0, 1.0), (), thin) == pytest.approx((0.0, 0.0), abs=1e-3)
    found = interior_point((-1.0, -1.0), (1.0, 1.0), (), corner)
    assert found is not None
    assert sum(found) > 1.99


def test_a_correction_slides_along_a_plane() -> None:
    """From a point on it; a way straight to an answer beyond it would have no admissible part."""
    limits = Limits.of(2, 10.0, half_spaces=(HalfSpace(weights=(0.0, 1.0), bound=2.0),))
    found = limits.nearest(np.array([5.0, 2.1]), np.array([0.0, 2.0]), np.full(2, -10.0), np.full(2, 10.0))

    assert found == pytest.approx([5.0, 2.0], abs=1e-5)
    assert found[1] <= 2.0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", LIMIT_SETS)
def test_what_is_not_finite_is_not_within(name: str) -> None:
    limits = limited(paper_design(), name).limits
    for strange in ((nan, 0.0), (0.0, inf), (-inf, inf), (inf, inf)):
        u = np.array(strange)
        assert not limits.excess(u, u, 1e-3) <= 0
