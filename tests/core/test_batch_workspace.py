"""Functions evaluated for many lanes at once are CasADi's, whatever is beside a lane."""

from collections.abc import Callable
from math import inf, nan

import casadi as ca
import numpy as np
import pytest

from passafe.batch.batch_workspace import VECTOR, BatchWorkspace
from passafe.errors import DesignError
from passafe.workspace import Array, BlockLayout, dense_function

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
    "constant": lambda _a, _b: ca.SX(0.3),
    "itself": lambda a, _: a,
}
ROUNDED: dict[str, Callable[..., ca.SX]] = {
    "aᵇ": ca.power,
    "a^1.7": lambda a, _: a**1.7,
    "exp": lambda a, _: ca.exp(a),
    "log": lambda a, _: ca.log(a),
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
    """What lanes and what CasADi make of every pair of hostile numbers."""
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    function = dense_function("f", [a, b], [expression(a, b)])
    grid = np.array([(p, q) for p in NUMBERS for q in NUMBERS]).T
    lanes = BatchWorkspace(BlockLayout.of({"a": 1, "b": 1, "f": 1}), grid.shape[1])
    lanes.block[:2, : lanes.used] = grid
    evaluate = lanes.bind(function, ["a", "b"], ["f"])
    evaluate()
    expected = [float(function(p, q)) for p, q in grid.T]
    return lanes.part("f")[0, : lanes.used], np.array(expected)


@pytest.mark.parametrize("name", EXACT)
def test_exact_operations_are_casadi_s_to_the_last_bit(name: str) -> None:
    got, expected = both(EXACT[name])

    np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("name", ROUNDED)
def test_other_operations_are_casadi_s_up_to_rounding(name: str) -> None:
    got, expected = both(ROUNDED[name])

    np.testing.assert_allclose(got, expected, rtol=1e-14)


def test_a_chosen_value_is_not_spoiled_by_one_that_is_not_chosen() -> None:
    a = ca.SX.sym("a")
    lanes = BatchWorkspace(BlockLayout.of({"a": 1, "f": 1}), 2)
    evaluate = lanes.bind(dense_function("f", [a], [ca.if_else(a > 0, 1 / a, 7)]), ["a"], ["f"])
    lanes.part("a")[0, :2] = 2.0, nan
    evaluate()

    assert lanes.part("f")[0, :2].tolist() == [0.5, 7.0]


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
    lanes = BatchWorkspace(BlockLayout.of({"x": 3, "values": 3, "early": 1, "same": 1, "constant": 1}), 40)
    evaluate = lanes.bind(function, ["x"], ["values", "early", "same", "constant"])
    lanes.part("x")[:] = np.random.default_rng(1).normal(size=(3, 40))
    evaluate()
    for lane in range(40):
        expected = [each.full().ravel().tolist() for each in function(lanes.part("x")[:, lane])]
        got = [lanes.part(name)[:, lane].tolist() for name in ("values", "early", "same", "constant")]
        assert got == expected


def test_a_lane_does_not_depend_on_the_others() -> None:
    x = ca.SX.sym("x", 2)
    f = ca.vertcat(ca.sin(x[0]) * ca.exp(x[1]), ca.tanh(x[0] / x[1]), ca.atan2(x[0], x[1]) ** 3)
    function = dense_function("f", [x], [f])
    values = np.random.default_rng(2).normal(size=(2, 3 * VECTOR + 1))

    def evaluated(columns: Array) -> Array:
        lanes = BatchWorkspace(BlockLayout.of({"x": 2, "f": 3}), columns.shape[1])
        lanes.part("x")[:, : lanes.used] = columns
        lanes.bind(function, ["x"], ["f"])()
        return lanes.part("f")[:, : lanes.used].copy()

    together = evaluated(values)
    for lane in range(values.shape[1]):
        assert np.array_equal(evaluated(values[:, lane : lane + 1])[:, 0], together[:, lane])
    assert np.array_equal(evaluated(values[:, ::-1])[:, ::-1], together)


@pytest.mark.parametrize(("used", "count"), [(1, 8), (8, 8), (9, 16), (1000, 1000)])
def test_there_are_whole_vectors_of_lanes(used: int, count: int) -> None:
    lanes = BatchWorkspace(BlockLayout.of({"x": 2}), used)

    assert (lanes.used, lanes.count) == (used, count)
    assert lanes.part("x").shape == (2, count)


def test_a_matrix_has_its_columns_first() -> None:
    lanes = BatchWorkspace(BlockLayout.of({"before": 1, "G": 6}), 8)
    lanes.part("G")[:, 3] = np.arange(6)

    assert lanes.matrix("G", (3, 2))[:, :, 3].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_an_operation_that_arrays_do_not_know_is_refused() -> None:
    a = ca.SX.sym("a")
    lanes = BatchWorkspace(BlockLayout.of({"a": 1, "f": 1}), 1)

    with pytest.raises(DesignError, match=r"lanes: got the operation OP_ERF, allowed OP_ACOS, .*OP_TANH"):
        lanes.bind(dense_function("f", [a], [ca.erf(a)]), ["a"], ["f"])
