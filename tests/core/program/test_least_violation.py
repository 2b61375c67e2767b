import numpy as np
import pytest
from program_residuals import residuals_of

from passafe.certificate import Tolerance, accepts
from passafe.numerics.workspace import Array
from passafe.program.solvers.least_violation import ETA, LeastViolationSolver

BOX_G = np.vstack((np.eye(2), -np.eye(2)))
BOX_D = np.full(4, -1.0)


def relaxed(G: Array, d: Array, limits_G: Array, limits_d: Array) -> Array | None:
    """Return the relaxation alone; the multipliers must balance it."""
    least = LeastViolationSolver(len(d), len(limits_d), G.shape[1]).solve(G, d, limits_G, limits_d)
    if least is None:
        return None
    assert (least.limit_weights >= 0).all()
    assert np.abs(G.T @ least.rows + limits_G.T @ least.limit_weights).max() <= 10 * ETA
    return least.rows


def test_rows_that_can_be_kept_need_nothing() -> None:
    assert relaxed(np.eye(2), np.array([0.5, -3.0]), BOX_G, BOX_D) == pytest.approx([0, 0], abs=1e-6)


def test_a_row_beyond_the_limits_is_missed_by_what_is_missing() -> None:
    """u₀ ≥ 4 within |u₀| ≤ 1."""
    assert relaxed(np.eye(2)[:1], np.array([4.0]), BOX_G, BOX_D) == pytest.approx([3.0], abs=1e-6)


def test_rows_that_contradict_one_another_share_in_least_squares() -> None:
    """u₀ ≥ 0.5, u₀ ≤ −0.3 twice: minimise (0.5 − u)² + 2(u + 0.3)² at u = −1/30."""
    G = np.array([[1.0, 0.0], [-1.0, 0.0], [-1.0, 0.0]])
    s = relaxed(G, np.array([0.5, 0.3, 0.3]), BOX_G, BOX_D)

    assert s == pytest.approx([0.5 + 0.1 / 3, 0.3 - 0.1 / 3, 0.3 - 0.1 / 3], abs=1e-6)


def test_a_row_that_nothing_contradicts_is_kept() -> None:
    G = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    s = relaxed(G, np.array([0.5, 0.5, 0.9]), BOX_G, BOX_D)

    assert s is not None
    assert s[2] == pytest.approx(0.0, abs=1e-5)


def test_a_row_without_gradient_is_missed_whatever_the_input() -> None:
    assert relaxed(np.zeros((1, 2)), np.array([2.0]), BOX_G, BOX_D) == pytest.approx([2.0], abs=1e-6)


def test_no_input_misses_random_rows_by_less() -> None:
    rng = np.random.default_rng(82)
    for _ in range(100):
        rows = rng.integers(1, 9)
        G = rng.normal(size=(rows, 2))
        G /= np.linalg.norm(G, axis=1)[:, None]
        d = rng.normal(size=rows)
        s = relaxed(G, d, BOX_G, BOX_D)
        tried = np.maximum(d[:, None] - G @ rng.uniform(-1, 1, (2, 2000)), 0)

        assert s is not None
        assert (s**2).sum() <= (tried**2).sum(axis=0).min() + 1e-6


def test_what_is_no_number_has_no_answer() -> None:
    assert relaxed(np.eye(2), np.array([np.nan, 0.0]), BOX_G, BOX_D) is None


def test_a_certificate_wants_all_of_it() -> None:
    G, d = np.eye(2), np.array([1.0, -1.0])
    z, lam, tolerance = np.array([1.0, 0.0]), np.array([1.0, 0.0]), Tolerance()

    assert accepts(tolerance, residuals_of(G, d, z, lam))
    assert not accepts(tolerance, residuals_of(G, d, z * 0.9, lam))
    assert not accepts(tolerance, residuals_of(G, d, z, lam + np.array([0, 1e-3])))
    assert not accepts(tolerance, residuals_of(G, d, z, -lam))
    assert not accepts(tolerance, residuals_of(G, d, z * np.nan, lam))
