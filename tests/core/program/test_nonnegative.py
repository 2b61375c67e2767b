"""Non-negative least squares keep the conditions of Kuhn and Tucker."""

import numpy as np
import pytest
from scipy.optimize import nnls

from passafe.numerics.workspace import Array
from passafe.program.solvers import nonnegative
from passafe.program.solvers.nonnegative import nonnegative_least_squares


@pytest.mark.parametrize("seed", range(60))
def test_answers_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng([62, seed])
    m, n = (int(k) for k in rng.integers(1, (10, 30)))
    A, b = rng.normal(size=(m, n)), rng.normal(size=m)
    if seed % 3 == 0:  # columns that nearly are one another
        A = np.repeat(A, 2, axis=1) + 1e-7 * rng.normal(size=(m, 2 * n))
    x = nonnegative_least_squares(A, b)
    assert x is not None
    assert (x >= 0).all()
    assert np.linalg.norm(A @ x - b) == pytest.approx(nnls(A, b)[1], rel=1e-9, abs=1e-9)
    assert (A.T @ (b - A @ x) <= 1e-9 * (1 + x.sum())).all()


def test_an_unknown_whose_slope_is_rounding_stays_out() -> None:
    """Columns that cancel leave the others slopes of rounding; letting those in by turns would not end."""
    near = np.array([[-0.825722, 1.0, 0.0, 1.0, 0.0], [-0.564078, 0.0, 1.0, 0.0, 1.0]])
    A = np.vstack((near, [2.80225e-3, -0.537946, -0.649147, -1.61721e-3, -1.34090e-3]))
    b = np.array([0.0, 0.0, 1.0])
    x = nonnegative_least_squares(A, b)
    assert x is not None
    assert np.linalg.norm(A @ x - b) == pytest.approx(nnls(A, b)[1], abs=1e-9)


def test_zero_is_the_answer_where_nothing_helps() -> None:
    x = nonnegative_least_squares(-np.eye(2), np.ones(2))
    assert x is not None
    assert x.tolist() == [0.0, 0.0]


def test_a_column_whose_slope_was_rounding_waits_for_another(monkeypatch: pytest.MonkeyPatch) -> None:
    within, calls = nonnegative._within, []

    def first_refused(A: Array, b: Array, x: Array, is_free: np.ndarray) -> Array:
        calls.append(is_free.tolist())
        if len(calls) == 1:
            is_free[:] = False
            return np.zeros(len(x))
        return within(A, b, x, is_free)

    monkeypatch.setattr(nonnegative, "_within", first_refused)
    x = nonnegative_least_squares(np.eye(2), np.array([1.0, 2.0]))

    assert x is not None
    assert x.tolist() == [1.0, 2.0]
    assert calls == [[False, True], [True, False], [True, True]]


def test_no_answer_in_the_rounds_that_there_are_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nonnegative, "STEPS", 0)

    assert nonnegative_least_squares(np.eye(2), np.array([1.0, 2.0])) is None
