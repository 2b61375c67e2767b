from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from passafe.enclosure import UNKNOWN, enclose
from passafe.errors import DesignError

x = ca.SX.sym("x", 2)
OPERATIONS: dict[str, Callable[[ca.SX, ca.SX], ca.SX]] = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "negative": lambda a, b: -a + 0 * b,
    "twice": lambda a, b: 2 * a + b,
    "product": lambda a, b: a * b,
    "square": lambda a, b: a**2 - b**2,
    "cube": lambda a, b: a**3 + b,
    "inverse": lambda a, b: 1 / (3 + a) + 1 / b,
    "quotient": lambda a, b: a / (b + 4),
    "by a number": lambda a, b: (a + b) / 7,
    "root": lambda a, b: ca.sqrt(a**2 + b**2 + 0.01),
    "root near zero": lambda a, b: ca.sqrt(ca.fmax(a, 0)) + b,
    "exponential": lambda a, b: ca.exp(a) - ca.exp(-b),
    "logarithm": lambda a, b: ca.log(a + 5) + b,
    "sine": lambda a, b: ca.sin(3 * a) * ca.cos(b),
    "hyperbolic": lambda a, b: ca.sinh(a) + ca.cosh(b),
    "saturations": lambda a, b: ca.tanh(a) + ca.atan(b),
    "magnitude": lambda a, b: ca.fabs(a) + ca.sign(b),
    "extremes": lambda a, b: ca.fmin(a, b) * ca.fmax(a, b),
    "pieces": lambda a, b: ca.if_else(a > 0, 2 * a, 5 * a) + b,
    "logic": lambda a, b: ca.if_else(ca.logic_and(a > 0, b > 0), a, 0) + ca.if_else(ca.logic_or(a <= 0, b < 0), b, 1),
    "norm": lambda a, b: ca.norm_2(ca.vertcat(a, b)),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_nothing_near_lies_outside_the_ball(name: str) -> None:
    expression = OPERATIONS[name](x[0], x[1])
    radius = ca.SX.sym("radius", 2)
    ball = enclose(expression, x, radius)
    value = ca.Function("value", [x], [expression])
    enclosed = ca.Function("ball", [x, radius], [ball.centre, ball.radius])
    rng = np.random.default_rng(70)
    for _ in range(40):
        at, reach = rng.uniform(-2, 2, 2), 10 ** rng.uniform(-3, -0.3, 2)
        centre, size = (float(part) for part in enclosed(at, reach))
        near = at[:, None] + reach[:, None] * np.hstack((rng.uniform(-1, 1, (2, 60)), [[-1, -1, 1, 1], [-1, 1, -1, 1]]))
        values = value(near).full().ravel()

        assert np.abs(values - centre).max() <= size + 1e-12 * (1 + np.abs(values).max())
        assert size < UNKNOWN or name == "inverse"


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_point_is_enclosed_by_its_value(name: str) -> None:
    expression = OPERATIONS[name](x[0], x[1])
    ball = enclose(expression, x, ca.SX.zeros(2))
    at = np.array([0.7, 0.4])
    centre, size, value = ca.Function("ball", [x], [ball.centre, ball.radius, expression])(at)

    assert float(size) == 0.0
    assert float(centre) == pytest.approx(float(value))


def test_an_affine_function_s_ball_is_as_small_as_can_be() -> None:
    ball = enclose(3 * x[0] - 2 * x[1] + 5, x, ca.SX([0.1, 0.2]))

    assert float(ca.Function("radius", [x], [ball.radius])([1, 1])) == pytest.approx(0.3 + 0.4)


@pytest.mark.parametrize("expression", [1 / x[0], ca.log(x[0])])
def test_where_the_function_ends_nothing_is_known(expression: ca.SX) -> None:
    radius = enclose(expression, x, ca.SX([0.5, 0.0])).radius

    assert float(ca.Function("radius", [x], [radius])([0.2, 0.0])) >= UNKNOWN


def test_a_comparison_may_be_either_where_its_sides_can_meet() -> None:
    ball = enclose(x[0] < 2 * x[1], x, ca.SX([0.1, 0.2]))
    radius = ca.Function("radius", [x], [ball.radius])

    assert [float(radius((at, 1.0))) for at in (2.4, 2.6, 1.6, 1.4, -2.0)] == [1.0, 0.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize("operation", [ca.logic_and, ca.logic_or])
def test_of_two_conditions_one_that_may_be_either_is_enough(operation: Callable[[ca.SX, ca.SX], ca.SX]) -> None:
    ball = enclose(operation(x[0] > 0, x[1] > 0), x, ca.SX([0.1, 0.1]))
    radius = ca.Function("radius", [x], [ball.radius])

    assert [float(radius(at)) for at in ([0.05, 1.0], [1.0, -0.05], [0.05, 0.0], [1.0, 1.0])] == [1.0, 1.0, 1.0, 0.0]


def test_other_symbols_stay_where_they_are() -> None:
    p = ca.SX.sym("p")
    ball = enclose(p * x[0], x, ca.SX([0.5, 0.0]))

    assert float(ca.Function("radius", [x, p], [ball.radius])([1.0, 0.0], 4.0)) == 2.0


def test_an_operation_without_a_rule_is_named() -> None:
    with pytest.raises(DesignError, match="OP_ERF"):
        enclose(ca.erf(x[0]), x, ca.SX([0.1, 0.1]))
