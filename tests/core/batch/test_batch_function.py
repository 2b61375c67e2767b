"""Functions evaluated for many elements at once are CasADi's, whatever is beside an element."""

from collections.abc import Callable
from math import inf, nan

import casadi as ca
import numpy as np
import pytest

from passafe.batch.batch_function import VECTOR, BatchFunction
from passafe.errors import DesignError
from passafe.numerics.workspace import Array, dense_function

EXACT: dict[str, Callable[..., ca.SX]] = {
    "a + b": lambda a, b: a + b,
    "a - b": lambda a, b: a - b,
    "a b": lambda a, b: a * b,
    "a / b": lambda a, b: a / b,
    "-a": lambda a, _: -a,
    "2 a": lambda a, _: a + a,
    "a²": lambda a, _: a**2,
    "1 / a": lambda a, _: 1 / a,
    "√a": lambda a, _: ca.sqrt(a),
    "|a|": lambda a, _: ca.fabs(a),
    "sign": lambda a, _: ca.sign(a),
    "fmin": ca.fmin,
    "fmax": ca.fmax,
    "<": ca.lt,
    "≤": ca.le,
    "=": ca.eq,
    "≠": ca.ne,
    "not": lambda a, _: ca.logic_not(a),
    "and": ca.logic_and,
    "or": ca.logic_or,
    "if": lambda a, b: ca.if_else(a > 0, b, 0),
    "if else": lambda a, b: ca.if_else(a > b, a / b, b / a),
    "copysign": ca.copysign,
    "⌊a⌋": lambda a, _: ca.floor(a),
    "⌈a⌉": lambda a, _: ca.ceil(a),
    "constant": lambda _a, _b: ca.SX(0.3),
    "itself": lambda a, _: a,
}
ROUNDED: dict[str, Callable[..., ca.SX]] = {
    "aᵇ": ca.power,
    "a^1.7": lambda a, _: a**1.7,
    "exp": lambda a, _: ca.exp(a),
    "log": lambda a, _: ca.log(a),
    "log1p": lambda a, _: ca.log1p(a),
    "expm1": lambda a, _: ca.expm1(a),
    "hypot": ca.hypot,
    "sin": lambda a, _: ca.sin(a),
    "cos": lambda a, _: ca.cos(a),
    "tan": lambda a, _: ca.tan(a),
    "asin": lambda a, _: ca.asin(a),
    "acos": lambda a, _: ca.acos(a),
    "atan": lambda a, _: ca.atan(a),
    "atan2": ca.atan2,
    "sinh": lambda a, _: ca.sinh(a),
    "cosh": lambda a, _: ca.cosh(a),
    "tanh": lambda a, _: ca.tanh(a),
}
NUMBERS = [0.0, 1.0, -1.0, 0.5, -0.7, 3.0, 1e-300, -1e300, inf, -inf, nan, 5e-324]


def both(expression: Callable[..., ca.SX]) -> tuple[Array, Array]:
    """Return what arrays and what CasADi make of every pair of hostile numbers."""
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    function = dense_function("f", [a, b], [expression(a, b)])
    grid = np.array([(p, q) for p in NUMBERS for q in NUMBERS]).T
    batch = BatchFunction(function)
    [got] = batch(grid[:1], grid[1:])
    expected = [float(function(p, q)) for p, q in grid.T]
    assert batch.is_vectorised
    return got[0], np.array(expected)


@pytest.mark.parametrize("name", EXACT)
def test_exact_operations_are_casadi_s_to_the_last_bit(name: str) -> None:
    got, expected = both(EXACT[name])

    np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("name", ROUNDED)
def test_other_operations_are_casadi_s_up_to_rounding(name: str) -> None:
    got, expected = both(ROUNDED[name])

    np.testing.assert_allclose(got, expected, rtol=1e-14)


def test_a_chosen_value_is_not_spoiled_by_the_other_one() -> None:
    a = ca.SX.sym("a")
    [got] = BatchFunction(dense_function("f", [a], [ca.if_else(a > 0, 1 / a, 7)]))(np.array([[2.0, nan]]))

    assert got.tolist() == [[0.5, 7.0]]


def test_places_are_used_again_and_results_may_repeat() -> None:
    """Many passing values, one result twice, results that others are made of, and an argument handed through."""
    x = ca.SX.sym("x", 3)
    total = x[0] + x[1] * x[2]
    early = ca.sqrt(total**2 + 2)
    value = ca.sqrt(early**2 + 1)
    for k in range(40):
        value = ca.sqrt(1 + value**2) + k * total
    results = [ca.vertcat(value, total, value), early, x[1], ca.SX(2.5)]
    function = dense_function("f", [x], results)
    columns = np.random.default_rng(1).normal(size=(3, 40))
    found = BatchFunction(function)(columns)
    for element in range(40):
        expected = [each.full().ravel().tolist() for each in function(columns[:, element])]
        assert [array[:, element].tolist() for array in found] == expected


def test_an_element_does_not_depend_on_the_others() -> None:
    x = ca.SX.sym("x", 2)
    f = ca.vertcat(ca.sin(x[0]) * ca.exp(x[1]), ca.tanh(x[0] / x[1]), ca.atan2(x[0], x[1]) ** 3)
    function = dense_function("f", [x], [f])
    values = np.random.default_rng(2).normal(size=(2, 3 * VECTOR + 1))

    batch = BatchFunction(function)
    [together] = batch(values)
    for element in range(values.shape[1]):
        assert np.array_equal(batch(values[:, element : element + 1])[0][:, 0], together[:, element])
    assert np.array_equal(batch(values[:, ::-1])[0][:, ::-1], together)


def test_a_bound_function_reads_and_writes_its_arrays() -> None:
    a = ca.SX.sym("a", 2)
    read, written = np.zeros((2, 5)), np.zeros((1, 5))
    evaluate = BatchFunction(dense_function("f", [a], [a[0] * a[1]])).bind([read], [written])
    for factor in (2.0, 3.0):
        read[:] = np.arange(10).reshape(2, 5) * factor
        evaluate()

        assert written.tolist() == [[factor**2 * k * (k + 5) for k in range(5)]]


@pytest.mark.parametrize("columns", [0, 3])
def test_a_function_without_results_has_no_rows(columns: int) -> None:
    a = ca.SX.sym("a")

    [found] = BatchFunction(dense_function("f", [a], [ca.SX(0, 1)]))(np.zeros((1, columns)))

    assert found.shape == (0, columns)


def test_an_operation_that_arrays_do_not_know_is_refused() -> None:
    a = ca.SX.sym("a")

    with pytest.raises(DesignError, match=r"batch: got the operation OP_ERF, allowed OP_ACOS, .*OP_TANH"):
        BatchFunction(dense_function("f", [a], [ca.erf(a)]))


def test_or_casadi_evaluates_the_function_if_so_wanted() -> None:
    a, b = ca.SX.sym("a", 2), ca.SX.sym("b")
    matrix = ca.horzcat(ca.erf(a), a * b, a - b)
    batch = BatchFunction(dense_function("f", [a, b], [matrix, ca.erf(b)]), by_casadi=True)
    first, second = np.random.default_rng(4).normal(size=(2, 5)), np.random.default_rng(5).normal(size=(1, 5))

    found = batch(first, second)

    assert not batch.is_vectorised
    assert [array.shape for array in found] == [(6, 5), (1, 5)]
    for element in range(5):
        expected = batch.function(first[:, element], second[:, element])
        assert [array[:, element].tolist() for array in found] == [e.full().ravel("F").tolist() for e in expected]
