from collections.abc import Sequence
from math import hypot, nan

import numpy as np
import pytest
from core_designs import DESIGNS, Builder, paper_design, random_state, row_filter, row_state
from scipy.optimize import linprog, minimize

from passafe.decision import Decision, Status
from passafe.decision_schema import Assessment, Program
from passafe.design import Mode
from passafe.filter import SafetyPassivityFilter
from passafe.limits import Limits
from passafe.numerics.workspace import Array, BlockLayout
from passafe.program.infeasibility import CLOSED, Distance, DistanceToInfeasibility

NO_RATE = (0.0, 0.0)


def posed(
    G: Array,
    d: Array,
    low: Array,
    high: Array,
    u_ref: Array | None = None,
    u_plus: Array | None = None,
) -> Decision:
    """Return the parts of a decision that the distance is read from: rows G w ≥ d, low ≤ u_ref + w ≤ high."""
    m = len(low)
    values = {
        "G": G,
        "d": d,
        "u_ref": np.zeros(m) if u_ref is None else u_ref,
        "low": low,
        "high": high,
        "u_plus": (low + high) / 2 if u_plus is None else u_plus,
    }
    shapes = dict.fromkeys(Program.names(), (0,)) | {name: value.shape for name, value in values.items()}
    layout = BlockLayout.of(shapes)
    block = np.concatenate([values[name].ravel(order="F") for name in layout.parts if name in values])
    nothing = Assessment.of(lambda _: 0.0)
    return Decision(block, layout, Status.MODIFIED, "none", nothing, (0.0,) * m)


def in_a_box(
    rows: Sequence[Sequence[float]], bound: float, norm: float | None = None, u_ref: Sequence[float] = (0.0, 0.0)
) -> Distance:
    """Return the distance of rows (g, c), gᵀu + c ≥ 0 with unit g, under |uᵢ| ≤ bound and ‖u‖ ≤ norm."""
    numbers, origin = np.array(rows, dtype=float), np.array(u_ref)
    m = numbers.shape[1] - 1
    limits = Limits.of(m, bound, norm, None)
    box, G = np.full(m, bound), numbers[:, :m]
    return DistanceToInfeasibility(limits, len(rows)).of(posed(G, -numbers[:, m] - G @ origin, -box, box, origin))


def assert_closed(distance: Distance, value: float, reach: float) -> None:
    assert distance.lower <= value + 1e-9 * reach
    assert distance.upper >= value - 1e-9 * reach
    assert distance.upper - distance.lower <= 2 * CLOSED * reach


@pytest.mark.parametrize(
    ("rows", "value"),
    [
        ([(1.0, 0.0, 2.0)], 12.0),  # u₁ ≥ −2: at u₁ = 10
        ([(1.0, 0.0, -11.0)], -1.0),  # u₁ ≥ 11 is one beyond the limit
        ([(1.0, 0.0, 1.0), (-1.0, 0.0, 3.0)], 2.0),  # −1 ≤ u₁ ≤ 3
        ([(1.0, 0.0, -1.0), (-1.0, 0.0, -1.0)], -1.0),  # 1 ≤ u₁ ≤ −1
        ([(1.0, 0.0, 0.0)] * 3, 10.0),  # duplicated
        ([(0.6, 0.8, 0.0)], 14.0),  # the corner (10, 10)
        ([(0.0, 0.0, -5.0)], -5.0),  # no gradient, not kept
        ([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-(0.5**0.5), -(0.5**0.5), 0.5**0.5)], 1 / (1 + 2 * 0.5**0.5) * 0.5**0.5),
    ],
)
def test_in_closed_form(rows: list[tuple[float, ...]], value: float) -> None:
    # The last but one input: the circle in the triangle u₁ ≥ 0, u₂ ≥ 0, u₁ + u₂ ≤ 1 has radius 1/(2 + √2).
    assert_closed(in_a_box(rows, 10.0), value, 2 * hypot(10.0, 10.0))


@pytest.mark.parametrize(
    ("rows", "value"),
    [
        ([(0.6, 0.8, 1.0)], 6.0),  # at the end of (0.6, 0.8)·5
        ([(0.6, 0.8, -7.0)], -2.0),
        ([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], 5 / 2**0.5),
        ([(1.0, 0.0, 1.0), (-1.0, 0.0, 3.0)], 2.0),  # the norm is not in the way
        ([(1.0, 0.0, 0.0), (0.0, 1.0, -3.0)], 0.5 * (41**0.5 - 3)),  # t² + (t + 3)² = 25
    ],
)
@pytest.mark.parametrize("u_ref", [(0.0, 0.0), (3.0, -1.0), (-2.0, -4.0)])
def test_in_closed_form_within_a_norm(rows: list[tuple[float, ...]], value: float, u_ref: tuple[float, float]) -> None:
    assert_closed(in_a_box(rows, 10.0, norm=5.0, u_ref=u_ref), value, 2 * hypot(10.0, 10.0))


def test_where_norm_and_axis_both_bind() -> None:
    # (0.6, 0.8)·u with |u₁| ≤ 1 and ‖u‖ ≤ 5: the corner (1, √24).
    limits = Limits.of(2, (1.0, 10.0), 5.0, None)
    box = np.array([1.0, 10.0])
    distance = DistanceToInfeasibility(limits, 1).of(posed(np.array([[0.6, 0.8]]), np.zeros(1), -box, box))

    assert_closed(distance, 0.6 + 0.8 * 24**0.5, limits.reach)


@pytest.mark.parametrize(("hard", "m"), [(1, 1), (2, 2), (20, 2), (6, 7), (20, 7), (250, 2)])
def test_it_is_the_optimum_of_the_linear_program(hard: int, m: int) -> None:
    rng = np.random.default_rng(hard * m)
    limits = Limits.of(m, 5.0, None, None)
    solver = DistanceToInfeasibility(limits, hard)
    for _ in range(20):
        G = rng.normal(size=(hard, m))
        G /= np.linalg.norm(G, axis=1)[:, None]
        d, u_ref = rng.normal(size=hard) * 3, rng.uniform(-5, 5, m)
        low, high = np.full(m, -5.0), np.full(m, 5.0)
        found = solver.of(posed(G, d, low, high, u_ref))
        exact = linprog(
            np.r_[np.zeros(m), -1.0],
            A_ub=np.hstack((-G, np.ones((hard, 1)))),
            b_ub=-d,
            bounds=[*zip(low - u_ref, high - u_ref, strict=True), (None, limits.reach)],
        )
        assert_closed(found, float(exact.x[-1]), limits.reach)


def test_within_a_norm_it_is_the_optimum_of_the_convex_program() -> None:
    rng = np.random.default_rng(3)
    limits = Limits.of(3, 5.0, 6.0, None)
    solver = DistanceToInfeasibility(limits, 4)
    box = np.full(3, 5.0)
    for _ in range(20):
        G = rng.normal(size=(4, 3))
        G /= np.linalg.norm(G, axis=1)[:, None]
        d, u_ref, u_plus = rng.normal(size=4), rng.uniform(-3, 3, 3), rng.uniform(-3, 3, 3)
        found = solver.of(posed(G, d - G @ u_ref, -box, box, u_ref, u_plus))
        constraints = [
            {"type": "ineq", "fun": lambda z, G=G, d=d: G @ z[:3] - d - z[3]},
            {"type": "ineq", "fun": lambda z: 36.0 - z[:3] @ z[:3]},
        ]
        best = minimize(lambda z: -z[3], np.zeros(4), constraints=constraints, bounds=[(-5, 5)] * 3 + [(None, None)])
        assert found.lower == pytest.approx(best.x[3], abs=1e-4)
        assert found.lower <= found.upper <= found.lower + 1e-3 * limits.reach


@pytest.mark.parametrize("builder", DESIGNS)
def test_exactly_infeasible_decisions_have_a_negative_distance(builder: Builder) -> None:
    core = SafetyPassivityFilter(builder(input_bound=3.0, between_samples=False))
    hard = core.derivation.rows.hard
    solver, system = DistanceToInfeasibility(core.design.limits, hard), core.design.system
    rng = np.random.default_rng(5)
    for _ in range(200):
        u_h = random_state(rng, system.m, 9.0)
        decision = core.decide(random_state(rng, system.n), random_state(rng, system.m), u_h, u_h, 0.7)
        distance = solver.of(decision)
        if decision.status is Status.INFEASIBLE:
            assert distance.lower < 0.0
        elif decision.status is not Status.UNCERTIFIED:
            assert distance.upper > -1e-5
        assert distance.lower >= min(float(decision.margins[:hard].min()), solver.reach) - 1e-5


def test_the_answer_does_not_depend_on_what_was_solved_before() -> None:
    core = row_filter(hard=2, soft=False)
    first = core.decide(row_state([(0.6, 0.8, -1.0), (1.0, -0.3, 2.0)]), NO_RATE, (9.0, 1.0), NO_RATE)
    other = core.decide(row_state([(-1.0, 0.0, -9.0), (0.1, 1.0, 50.0)]), NO_RATE, (-9.0, 1.0), NO_RATE)
    used = DistanceToInfeasibility(core.design.limits, 2)
    before = used.of(first)
    used.of(other)

    assert used.of(first) == before == DistanceToInfeasibility(core.design.limits, 2).of(first)


def test_without_hard_rows_it_is_the_reach() -> None:
    core = SafetyPassivityFilter(paper_design(mode=Mode.PASSIVE))
    decision = core.decide((2.0, 2.0, -1.0, -1.0), NO_RATE, NO_RATE, NO_RATE)
    solver = DistanceToInfeasibility(core.design.limits, 0)

    assert solver.of(decision) == Distance(lower=solver.reach, upper=solver.reach)


def test_row_out_of_reach_has_the_reach_as_distance() -> None:
    assert in_a_box([(1.0, 0.0, 1e3)], 10.0) == Distance(lower=2 * hypot(10, 10), upper=2 * hypot(10, 10))


def test_rows_that_are_no_numbers_have_the_floor() -> None:
    solver = DistanceToInfeasibility(Limits.of(2, 10.0, None, None), 1)
    box = np.full(2, 10.0)
    distance = solver.of(posed(np.array([[nan, 1.0]]), np.zeros(1), -box, box))

    assert distance == Distance(lower=solver.floor, upper=solver.reach)


def test_where_one_row_decides_no_program_is_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """(0.6, 0.8)ᵀu ≥ 1 is kept best at the corner (10, 10), u₁ ≥ −30 better than that there."""
    solver = DistanceToInfeasibility(Limits.of(2, 10.0, None, None), 2)
    monkeypatch.setattr(solver, "_ask", pytest.fail)
    box = np.full(2, 10.0)
    distance = solver.of(posed(np.array([[1.0, 0.0], [0.6, 0.8]]), np.array([-30.0, 1.0]), -box, box))

    assert (distance.lower, distance.upper) == pytest.approx((13.0, 13.0))


def test_failed_solver_leaves_the_bounds_of_single_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """u₁ ≥ 0 and u₁ ≤ 0: at u₁ = 4 the second is missed by 4, and neither is kept by more than 10."""
    solver = DistanceToInfeasibility(Limits.of(2, 10.0, None, None), 2)
    box = np.full(2, 10.0)

    class Failing:
        def update(self, **_: object) -> int:
            return -1

        def solve(self) -> tuple[Array, float, int, dict[str, Array]]:
            return np.zeros(3), 0.0, -1, {}

    monkeypatch.setattr(solver, "_model", Failing())
    opposed = np.array([[1.0, 0.0], [-1.0, 0.0]])
    distance = solver.of(posed(opposed, np.zeros(2), -box, box, u_plus=np.array([4.0, 0.0])))

    assert distance == Distance(lower=-4.0, upper=10.0)


def test_weights_prove_what_no_input_within_the_limits_exceeds(monkeypatch: pytest.MonkeyPatch) -> None:
    """(g₁ + 3g₂)/4 = (−1/4, 3/4) reaches 10·1/4 + 6·3/4 between −10 ≤ u ≤ (2, 6), of which the bounds take 2.

    Alone row 1 proves 9.2 and row 2 6.8, which is kept so well at (−10, 6), where row 1 is missed by 0.4.
    """
    solver = DistanceToInfeasibility(Limits.of(2, 10.0, None, None), 2)
    monkeypatch.setattr(solver, "_ask", lambda: (np.zeros(2), np.array([1.0, 3.0])))
    low, high = np.array([-10.0, -10.0]), np.array([2.0, 6.0])
    rows = np.array([[0.8, 0.6], [-0.6, 0.8]])
    distance = solver.of(posed(rows, np.array([-4.0, 4.0]), low, high, u_plus=np.zeros(2)))

    assert (distance.lower, distance.upper) == pytest.approx((-0.4, 5.0))


def test_weights_that_prove_nothing_leave_what_the_row_proves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the norm 5 towards the corner (10, −10), and not beyond the axis' limit."""
    solver = DistanceToInfeasibility(Limits.of(2, 10.0, 5.0, None), 1)
    box = np.full(2, 10.0)
    monkeypatch.setattr(solver, "_ask", lambda: (np.zeros(2), np.zeros(1)))
    distance = solver.of(posed(np.array([[1.0, 0.0]]), np.zeros(1), -box, box, u_plus=np.zeros(2)))

    assert (distance.lower, distance.upper) == pytest.approx((5 / 2**0.5, 10.0))
