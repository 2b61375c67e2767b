"""Bounds of the error of computed expressions, against exact arithmetic in fractions."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from passafe_services.tools.review.rounding_error import ROUNDING, rounding_error

X = ca.SX.sym("x", 2)


def bound_of(expression: ca.SX, x: tuple[float, float], error: float) -> list[float]:
    function = ca.Function("bound", [X], [rounding_error(expression, X, ca.DM([error, error]))])
    bound: list[float] = function(ca.DM(list(x))).full().ravel().tolist()
    return bound


def test_rounding_of_cancelling_terms_is_covered_and_not_by_much() -> None:
    h = ca.sumsqr(X - ca.DM([1e3, -2e3])) - 1e6
    evaluate = ca.Function("h", [X], [h])
    for angle in np.random.default_rng(5).uniform(0, 7, 200):
        x = (1e3 + 1e3 * np.cos(angle), -2e3 + 1e3 * np.sin(angle))
        exact = (Fraction(x[0]) - 1000) ** 2 + (Fraction(x[1]) + 2000) ** 2 - 1_000_000
        [bound] = bound_of(h, x, 0.0)

        assert abs(Fraction(float(evaluate(ca.DM(list(x))))) - exact) <= bound
        assert bound < 4e-9


def test_an_error_of_the_state_is_passed_on_along_the_gradient() -> None:
    square, root = bound_of(ca.vertcat(X[0] ** 2, ca.sqrt(X[1])), (3.0, 4.0), 1e-6)

    assert square == pytest.approx(6e-6, rel=1e-6)
    assert root == pytest.approx(0.25e-6, rel=1e-6)


def test_a_state_by_itself_is_computed_exactly() -> None:
    constant, state = bound_of(ca.vertcat(ca.SX(2.5), X[0]), (3.0, 4.0), 0.0)

    assert (constant, state) == (0.0, 0.0)
    assert bound_of(2 * X[0], (3.0, 4.0), 0.0) == [6 * ROUNDING]


def test_no_expression_has_no_error() -> None:
    assert bound_of(ca.SX(0, 1), (1.0, 1.0), 1.0) == []
