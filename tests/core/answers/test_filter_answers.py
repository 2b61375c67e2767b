"""Decisions on arbitrary rows against the closed-form solution: see ``core_designs.row_filter``."""

from collections import Counter
from math import sqrt

import numpy as np
import pytest
from core_designs import row_filter, row_state
from random_programs import KINDS, Array, random_programs
from two_row_oracle import Minimiser, solve_exactly

from passafe.answers.replaced_answer import BACKUP, BETWEEN, DEEPEST
from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter

ZERO = (0.0, 0.0)
BOUND = 100.0
SLACK_WEIGHT = 1e4
WELL_POSED = ("generic", "parallel", "duplicated", "nearly parallel")


def hard_programs(seed: int, count: int, kinds: tuple[str, ...]) -> list[tuple[str, Array, Array]]:
    """Two rows with gradients of any length from 1e-9 to 100: (kind, rows, bounds)."""
    rng = np.random.default_rng(seed)
    programs = []
    for kind, G, d in random_programs(seed, count, 2, kinds):
        lengths = 10 ** rng.uniform(-9, 2, 2)
        programs.append((kind, G * lengths[:, None], d * lengths))
    return programs


def decide(made: SafetyPassivityFilter, rows: list[Array], bounds: list[float]) -> Decision:
    """Put rows gᵢᵀu⁺ ≥ bᵢ to a filter; at rest without a request, so that z = u⁺."""
    state = row_state([(*g, -b) for g, b in zip(rows, bounds, strict=True)])
    return made.decide(state, ZERO, ZERO, ZERO)


def needs_more_than_the_bound(exact: Minimiser | None) -> bool:
    return exact is None or bool(np.abs(exact.z[:2]).max() > BOUND * (1 - 1e-6))


def assert_near_minimiser(decision: Decision) -> None:
    """Within √(2·gap) of the minimiser of the rows that the answer keeps exactly: the certificate's guarantee."""
    z, constraints = decision.part("z"), decision.part("d").size
    if decision.duals[constraints:].max() > 0:
        return  # a limit is among the rows that decide; the closed form knows two rows only
    d, lam, margins = decision.part("d"), np.maximum(decision.duals[:constraints], 0), decision.margins[:constraints]
    G = decision.part("G").reshape((constraints, z.size), order="F")
    kept = d + np.minimum(margins, 0)
    pull = G.T @ lam
    gap = max(float(z @ z / 2 - lam @ kept + pull @ pull / 2), 0.0)
    nearest = solve_exactly(G, kept - 1e-15)

    assert nearest is not None
    assert np.linalg.norm(z - nearest.z) <= sqrt(2 * gap) + 1e-7 * (1 + np.linalg.norm(z))


def assert_all_that_the_bound_leaves(decision: Decision) -> None:
    """Check an answer that rows alone put beyond the bound: on it, and the rows kept if any input keeps them."""
    if decision.solver in {BACKUP, BETWEEN, DEEPEST}:
        return
    assert max(map(abs, decision.u)) == pytest.approx(BOUND, rel=1e-5)
    if decision.status is not Status.UNCERTIFIED:
        assert_consistent_with_relaxation(decision)


def assert_consistent_with_relaxation(decision: Decision) -> None:
    relax = decision.part("relax")
    assert (decision.margins[: relax.size] >= -relax - 1e-5 * (1 + np.abs(decision.part("d")[: relax.size]))).all()
    assert (decision.status is Status.INFEASIBLE) == bool(relax.any())


def test_two_hard_rows_are_answered_as_in_closed_form() -> None:
    made = row_filter(hard=2, soft=False, input_bound=BOUND)
    seen: Counter[Status] = Counter()
    for kind, G, b in hard_programs(50, 1600, WELL_POSED):
        exact = solve_exactly(G, b)
        decision = decide(made, list(G), list(b))
        seen[decision.status] += 1
        if needs_more_than_the_bound(exact):
            assert_all_that_the_bound_leaves(decision)
            continue
        assert exact is not None
        scale = 1 + float(np.linalg.norm(exact.z))
        assert not decision.status.is_fallback, (kind, G, b)
        assert decision.u == pytest.approx(exact.z, abs=2e-4 * scale)
        assert (decision.status is Status.PASSED) == (not exact.z.any())
        assert_near_minimiser(decision)
    assert min(seen[status] for status in (Status.PASSED, Status.MODIFIED)) > 100


def test_a_hard_and_a_soft_row_are_answered_as_in_closed_form() -> None:
    """The soft row g₃ᵀu + c₃ + δ ≥ 0 at ½ρδ² is the row (g₃, 1/√ρ) over (u, √ρ·δ)."""
    made = row_filter(hard=1, soft=True, slack_weight=SLACK_WEIGHT, input_bound=BOUND)
    root = sqrt(SLACK_WEIGHT)
    rng = np.random.default_rng(51)
    seen: Counter[Status] = Counter()
    for _ in range(1000):
        hard, soft = rng.normal(size=(2, 2)) * 10 ** rng.uniform(-6, 2, (2, 1))
        b = rng.normal(size=2) * 10 ** rng.uniform(-6, 2, 2) * [np.linalg.norm(hard), 1]
        exact = solve_exactly([[*hard, 0.0], [*soft, 1 / root]], b)
        state = row_state([(*hard, -b[0]), (0, 0, 0), (*soft, -b[1])])
        decision = made.decide(state, ZERO, ZERO, ZERO)
        seen[decision.status] += 1
        if needs_more_than_the_bound(exact):
            assert_consistent_with_relaxation(decision)
            continue
        assert exact is not None
        assert not decision.status.is_fallback
        assert_near_minimiser(decision)
        scale = 1 + float(np.linalg.norm(exact.z))
        assert decision.u == pytest.approx(exact.z[:2], abs=2e-3 * scale)
        assert decision.slack == pytest.approx(exact.z[2] / root, abs=2e-3 * scale / root)
        assert decision.power_margin >= -decision.slack - 1e-6 * (1 + np.linalg.norm(soft)) * (
            1 + np.linalg.norm(exact.z)
        )
    assert min(seen[status] for status in (Status.PASSED, Status.MODIFIED, Status.RELAXED)) > 50


def test_every_accepted_answer_is_guaranteed_whatever_the_rows() -> None:
    made = row_filter(hard=2, soft=False, input_bound=BOUND)
    accepted = 0
    for _, G, b in hard_programs(52, 1500, KINDS):
        decision = decide(made, list(G), list(b))
        if not decision.status.is_fallback:
            accepted += 1
            assert_near_minimiser(decision)
    assert accepted > 750


def test_conflicts_and_demands_beyond_the_bound_are_refused() -> None:
    made = row_filter(hard=2, soft=False, input_bound=BOUND)
    refused: Counter[Status] = Counter()
    for kind, G, b in hard_programs(53, 1000, ("antiparallel", "nearly antiparallel", "without gradient")):
        lengths = np.linalg.norm(G, axis=1)
        within = 2e-6 * (1 + 2 * BOUND) * np.where(lengths > 0, lengths, 1.0)  # what the primal residual may hide
        if not needs_more_than_the_bound(solve_exactly(G, b - within)):
            continue
        decision = decide(made, list(G), list(b))
        refused[decision.status] += 1

        assert decision.status.is_fallback, (kind, G, b)
        assert max(map(abs, decision.u)) <= BOUND
    assert refused[Status.INFEASIBLE] > 100


def test_infeasible_is_said_of_nothing_that_can_be_kept() -> None:
    """Rows almost opposite to each other leave a wedge; its tip may be far, but it is there within the bound."""
    made = row_filter(hard=2, soft=False, input_bound=BOUND)
    wrong = []
    for _, G, b in hard_programs(54, 2000, ("nearly antiparallel", "generic")):
        exact = solve_exactly(G, b)
        if exact is None or np.abs(exact.z).max() > BOUND / 2:
            continue
        decision = decide(made, list(G), list(b))
        if decision.status is Status.INFEASIBLE:
            wrong.append((G.tolist(), b.tolist(), exact.z.tolist()))
    assert wrong == []


def test_a_row_without_gradient_is_kept_or_failing() -> None:
    made = row_filter(hard=1, soft=False)
    for length in (0.0, 5e-324, 1e-200, 1e-13):
        assert decide(made, [np.array([length, 0.0])], [-1e-3]).status is Status.PASSED
        assert decide(made, [np.array([length, 0.0])], [1e-3]).status is Status.INFEASIBLE


def test_a_tiny_gradient_is_used_as_well_as_a_large_one() -> None:
    made = row_filter(hard=1, soft=False)
    for length in (1e-10, 1e-6, 1.0, 1e6, 1e12):
        decision = decide(made, [np.array([0.6, 0.8]) * length], [5 * length])

        assert decision.status is Status.MODIFIED
        assert decision.u == pytest.approx((3.0, 4.0), abs=1e-5)


def test_a_soft_row_alone_is_never_infeasible() -> None:
    """Slack can always keep it, so nothing conflicts."""
    made = row_filter(hard=0, soft=True, slack_weight=SLACK_WEIGHT, input_bound=BOUND)
    for shortfall in (1.0, 1e2, 1e4):
        decision = made.decide(row_state([(0, 0, 0), (0, 0, 0), (0.5, 0.5, -shortfall)]), ZERO, ZERO, ZERO)

        assert decision.status is not Status.INFEASIBLE, shortfall
