from math import inf, nan, sqrt

import casadi as ca
import numpy as np
import pytest
from program_residuals import residuals_of
from random_programs import KINDS, Array, random_programs, unit
from two_row_oracle import solve_exactly

from passafe.certificate import Residuals, Tolerance, accepts, certificate_residuals

TOLERANCE = Tolerance()


def judge(G: Array, d: Array, z: Array, lam: Array) -> tuple[Array, Residuals[float]]:
    """Return margins and residuals."""
    with np.errstate(invalid="ignore"):  # some tests put numbers into it that are none
        return np.asarray(G @ z - d), residuals_of(G, d, z, lam)


def numbers(residuals: Residuals[float]) -> list[float]:
    """Return primal, dual and gap."""
    return [residuals.primal, residuals.dual, residuals.gap]


def accepted(residuals: Residuals[float]) -> bool:
    """Evaluate the filter's own acceptance."""
    return accepts(TOLERANCE, residuals)


def test_oracle_knows_the_textbook_cases() -> None:
    """One row, a corner, a wedge whose corner is not the answer, and a conflict."""
    one = solve_exactly([[0.6, 0.8]], [5.0])
    corner = solve_exactly([[1, 0], [0, 1]], [2, 3])
    wedge = solve_exactly([[1, 0], [0, 1]], [2, -3])

    assert one is not None
    assert one.z == pytest.approx([3.0, 4.0])
    assert corner is not None
    assert (corner.z.tolist(), corner.lam.tolist()) == ([2, 3], [2, 3])
    assert wedge is not None
    assert (wedge.z.tolist(), wedge.lam.tolist()) == ([2, 0], [2, 0])
    assert solve_exactly([[1, 0], [-1, 0]], [1, 1]) is None
    assert solve_exactly([[0, 0]], [1]) is None


def test_residuals_in_closed_form() -> None:
    G, d = np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([2.0, 1.0])
    z, lam = np.array([3.0, 0.0]), np.array([2.5, -0.25])
    margins, residuals = judge(G, d, z, lam)

    # z = (3, 0): ‖z‖ = 3; Gᵀλ = (2.5, −0.25); dual value λᵀd − ½‖Gᵀλ‖²
    assert margins.tolist() == [1.0, -1.0]
    assert residuals.primal == pytest.approx(1.0 / 4)
    assert residuals.dual == pytest.approx(0.5 / 4)
    assert residuals.gap == pytest.approx(abs(4.5 - (5 - 0.25 - (6.25 + 0.0625) / 2)) / 10)


@pytest.mark.parametrize("size", [2, 3])
def test_the_minimiser_and_its_multipliers_leave_no_residual(size: int) -> None:
    for _, G, d in random_programs(20, 300, size, ("generic", "parallel", "duplicated", "without gradient")):
        exact = solve_exactly(G, d)
        if exact is not None and np.linalg.norm(exact.lam) < 1e6:
            _, residuals = judge(G, d, *exact)

            assert numbers(residuals) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("size", [2, 3])
def test_nothing_is_accepted_but_what_lies_near_the_minimiser(size: int) -> None:
    """Strong convexity: z that keeps G z ≥ d′ lies within √(2·gap) of the minimiser for d′, for any λ ≥ 0.

    The theorem is applied to accepted answers with d′ = min(d, G z), which they keep exactly, and to λ clipped at 0.
    """
    rng = np.random.default_rng(21)
    verdicts = {True: 0, False: 0}
    for _, G, d in random_programs(22, 900, size):
        exact = solve_exactly(G, d)
        if exact is None or np.linalg.norm(exact.lam) > 1e3:
            continue
        z = exact.z + rng.normal(size=size) * 10 ** rng.uniform(-12, 0)
        lam = exact.lam + rng.normal(size=2) * 10 ** rng.uniform(-12, 0)
        margins, residuals = judge(G, d, z, lam)
        verdict = accepted(residuals)
        verdicts[verdict] += 1
        if not verdict:
            continue
        kept = d + np.minimum(margins, 0)
        clipped = np.maximum(lam, 0)
        pull = G.T @ clipped
        gap = max(float(z @ z / 2 - clipped @ kept + pull @ pull / 2), 0.0)
        nearest = solve_exactly(G, kept - 1e-15)
        scale = 1 + np.linalg.norm(z)

        assert nearest is not None
        assert np.linalg.norm(z - nearest.z) <= sqrt(2 * gap) + 1e-7 * scale
        assert margins.min() >= -TOLERANCE.residual * scale
    assert min(verdicts.values()) > 100


@pytest.mark.parametrize("size", [1, 2, 3])
def test_a_feasible_answer_lies_within_the_root_of_twice_the_gap(size: int) -> None:
    """The claim of ``Tolerance`` for every feasible z and every λ ≥ 0, accepted or not."""
    rng = np.random.default_rng(23)
    tried = 0
    for _, G, d in random_programs(24, 900, size):
        exact = solve_exactly(G, d)
        if exact is None or np.linalg.norm(exact.z) > 1e4:
            continue
        z = exact.z + rng.normal(size=size) * 10 ** rng.uniform(-6, 1)
        if (G @ z < d).any():
            continue
        lam = np.abs(exact.lam + rng.normal(size=2) * 10 ** rng.uniform(-6, 1))
        _, residuals = judge(G, d, z, lam)
        gap = residuals.gap * (1 + z @ z)
        tried += 1

        assert np.linalg.norm(z - exact.z) <= sqrt(2 * gap) + 1e-7 * (1 + np.linalg.norm(z))
    assert tried > 100


def test_perturbed_answers_and_wrong_multipliers_are_rejected() -> None:
    rng = np.random.default_rng(25)
    for _, G, d in random_programs(26, 500, 2, ("generic",)):
        exact = solve_exactly(G, d)
        assert exact is not None
        scale = 1e-2 * (1 + np.linalg.norm(exact.z))
        off, wrong = unit(rng.normal(size=2)) * scale, np.eye(2)[rng.integers(2)] * scale

        assert accepted(judge(G, d, *exact)[1])
        assert not accepted(judge(G, d, exact.z + off, exact.lam)[1])
        assert not accepted(judge(G, d, exact.z, exact.lam + wrong)[1])
        if exact.lam.max() > 0.1:
            assert not accepted(judge(G, d, 1.1 * exact.z, 1.1 * exact.lam)[1])
            assert not accepted(judge(G, d, np.zeros(2), np.zeros(2))[1])
            assert not accepted(judge(G, d, exact.z, -exact.lam)[1])


@pytest.mark.parametrize("invalid", [nan, inf, -inf])
def test_a_nan_or_infinity_in_any_place_is_rejected(invalid: float) -> None:
    G, d = np.array([[1.0, 0.0], [0.6, 0.8]]), np.array([2.0, -1.0])
    exact = solve_exactly(G, d)
    assert exact is not None
    parts = [G, d, *exact]
    assert accepted(judge(G, d, *exact)[1])
    for i, part in enumerate(parts):
        for place in range(part.size):
            spoiled = [one.copy() for one in parts]
            spoiled[i].flat[place] = invalid

            assert not accepted(judge(*spoiled)[1]), f"argument {i}, place {place}"


def test_negative_multiplier_is_rejected_even_if_stationary() -> None:
    """Duplicated rows can share a pull as 3 − 1 = 2: stationary, no gap, but λ₂ < 0."""
    G, d, z = np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([2.0, 2.0]), np.array([2.0, 0.0])

    assert numbers(judge(G, d, z, np.array([1.5, 0.5]))[1]) == [0.0, 0.0, 0.0]
    assert numbers(judge(G, d, z, np.array([3.0, -1.0]))[1]) == [0.0, pytest.approx(1 / 3), 0.0]


def test_without_rows_only_the_origin_is_accepted() -> None:
    G, none = np.zeros((0, 2)), np.zeros(0)

    assert numbers(judge(G, none, np.zeros(2), none)[1]) == [0.0, 0.0, 0.0]
    assert numbers(judge(G, none, np.array([3.0, 4.0]), none)[1]) == [0.0, 5.0, 25.0]
    assert not accepted(judge(G, none, np.array([nan, 0.0]), none)[1])


def test_residuals_are_relative_to_the_size_of_the_answer() -> None:
    G, d, lam = np.array([[1.0]]), np.array([1e6]), np.array([1e6])

    _, residuals = judge(G, d, np.array([1e6 - 0.5]), lam)

    assert residuals.primal == pytest.approx(5e-7, rel=1e-3)
    assert accepted(residuals)


def test_plain_residuals_are_those_of_the_expression() -> None:
    G, d, z, lam = ca.SX.sym("G", 2, 3), ca.SX.sym("d", 2), ca.SX.sym("z", 3), ca.SX.sym("lam", 2)
    expressions = list(certificate_residuals(z, lam, G, d).fields().values())
    expected = ca.Function("residuals", [G, d, z, lam], expressions)
    rng = np.random.default_rng(27)
    for _, rows, bounds in random_programs(28, 50, 3, KINDS):
        answer, multipliers = rng.normal(size=3), rng.normal(size=2)

        assert numbers(residuals_of(rows, bounds, answer, multipliers)) == list(
            map(float, expected(rows, bounds, answer, multipliers))
        )


def test_a_batch_is_accepted_element_by_element() -> None:
    limit, more = TOLERANCE.residual, 2 * TOLERANCE.residual
    batch = Residuals(
        primal=np.array([limit, more, limit, limit, nan]),
        dual=np.array([limit, limit, more, limit, limit]),
        gap=np.array([TOLERANCE.gap, 0.0, 0.0, 2 * TOLERANCE.gap, 0.0]),
    )

    assert accepts(TOLERANCE, batch).tolist() == [True, False, False, False, False]
