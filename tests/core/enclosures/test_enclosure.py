"""Enclosures of single operations and of what is made of them: never too small, and no larger than theory allows."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from passafe.enclosures.enclosure import enclose
from passafe.errors import DesignError

x = ca.SX.sym("x", 2)
Operation = Callable[[ca.SX, ca.SX], ca.SX]
OPERATIONS: dict[str, Operation] = {
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
    "exponential": lambda a, b: ca.exp(a) - ca.exp(-b),
    "exponential less one": lambda a, b: ca.expm1(3 * a) * b,
    "logarithm": lambda a, b: ca.log(a + 5) + b,
    "logarithm of one more": lambda a, b: ca.log1p(a + 3) + b,
    "sine": lambda a, b: ca.sin(3 * a) * ca.cos(b),
    "tangent": lambda a, b: ca.tan(a / 2) + b,
    "arcsine": lambda a, b: ca.asin(a / 4) + ca.acos(b / 3),
    "hyperbolic": lambda a, b: ca.sinh(a) + ca.cosh(b),
    "inverse hyperbolic": lambda a, b: ca.asinh(a) + ca.acosh(b + 5) + ca.atanh(a / 4),
    "saturations": lambda a, b: ca.tanh(a) + ca.atan(b),
    "errors": lambda a, b: ca.erf(a) + ca.erfinv(b / 4),
    "direction": lambda a, b: ca.atan2(a, b + 5) + ca.atan2(b - 6, a),
    "distance": ca.hypot,
    "real power": lambda a, b: (a + 5) ** 2.7 + (b + 5) ** 0.3,
    "negative power": lambda a, b: (a + 5) ** -1.5 + (b + 5) ** (-101) * 1e40,
    "high power": lambda a, b: (a / 2) ** 102 + (b / 2) ** 101,
    "power of symbols": lambda a, b: (a + 5) ** b,
    "power of a number": lambda a, b: 2**a + b,
    "magnitude": lambda a, b: ca.fabs(a) + ca.sign(b),
    "copied sign": ca.copysign,
    "extremes": lambda a, b: ca.fmin(a, b) * ca.fmax(a, b),
    "slope of an extreme": lambda a, b: ca.gradient(ca.fmin(a, 2 * b) * ca.fmax(a * b, 1), x)[0],
    "slope of a magnitude": lambda a, b: ca.gradient(a * ca.fabs(a) + ca.fabs(b), x)[1],
    "pieces": lambda a, b: ca.if_else(a > 0, 2 * a, 5 * a) + b,
    "logic": lambda a, b: ca.if_else(ca.logic_and(a > 0, b > 0), a, 0) + ca.if_else(ca.logic_or(a <= 0, b < 0), b, 1),
    "number as a condition": lambda a, b: ca.if_else(a, b, ca.logic_not(b)),
    "norm": lambda a, b: ca.norm_2(ca.vertcat(a, b)),
}
JUMPS = {"magnitude", "copied sign", "slope of an extreme", "slope of a magnitude", "logic", "number as a condition"}


def enclosed(expression: ca.SX) -> Callable[[np.ndarray, np.ndarray], tuple[float, float, float]]:
    """Return centre, radius and known of a scalar as a function of x and its radius."""
    radius = ca.SX.sym("radius", 2)
    function = ca.Function("ball", [x, radius], list(enclose(expression, x, radius)))

    def evaluated(at: np.ndarray, reach: np.ndarray) -> tuple[float, float, float]:
        centre, size, known = (float(part) for part in function(at, reach))
        assert np.isfinite([centre, size]).all()
        assert known in {0.0, 1.0}
        return centre, size, known

    return evaluated


def nearby(rng: np.random.Generator, at: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return points of the box about a point, shape (2, k), corners, edges and the centre among them."""
    units = rng.uniform(-1, 1, (2, 60))
    edges = np.sign(units) ** rng.integers(0, 2, (2, 60)) * units
    corners = np.array([[-1, -1, 1, 1, 0, -1, 1, 0, 0], [-1, 1, -1, 1, 0, 0, 0, -1, 1]])
    near: np.ndarray = at[:, None] + reach[:, None] * np.hstack((units, edges, np.sign(units), corners))
    return near


@pytest.mark.parametrize("name", OPERATIONS)
def test_nothing_near_lies_outside_the_ball(name: str) -> None:
    expression = OPERATIONS[name](x[0], x[1])
    ball, value = enclosed(expression), ca.Function("value", [x], [expression])
    rng = np.random.default_rng(70)
    unknown = 0
    for _ in range(80):
        at, reach = rng.uniform(-2, 2, 2), 10 ** rng.uniform(-3, -0.3, 2)
        centre, size, known = ball(at, reach)
        values = value(nearby(rng, at, reach)).full().ravel()
        unknown += not known

        assert not known or np.abs(values - centre).max() <= size + 1e-12 * (1 + np.abs(values).max())
    assert unknown == 0 or name == "inverse"
    assert unknown < 20


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_point_is_enclosed_by_its_value(name: str) -> None:
    expression = OPERATIONS[name](x[0], x[1])
    at = np.array([0.7, 0.4])
    centre, size, known = enclosed(expression)(at, np.zeros(2))

    assert (size, known) == (0.0, 1.0)
    assert centre == pytest.approx(float(ca.Function("value", [x], [expression])(at)))


@pytest.mark.parametrize("name", [name for name in OPERATIONS if name not in JUMPS])
def test_width_shrinks_with_the_radius_to_that_of_the_slope(name: str) -> None:
    """A ball's radius tends to Σ |∂e/∂xᵢ| rᵢ, or to that of the parts where an operation has two arguments."""
    expression = OPERATIONS[name](x[0], x[1])
    at, unit = np.array([0.61, 0.43]), np.array([1.0, 0.7])
    ball = enclosed(expression)
    slope = np.abs(ca.Function("slope", [x], [ca.gradient(expression, x)])(at).full().ravel())
    sizes = [ball(at, unit * reach)[1] / reach for reach in (1e-3, 1e-6, 1e-9)]

    assert slope @ unit <= sizes[2] * (1 + 1e-5)
    assert sizes[2] <= slope @ unit * 1.7
    assert sizes[1] == pytest.approx(sizes[2], rel=1e-3)


EDGES = [0.0, -0.0, 5e-324, 1e-308, 1e-160, 1e-16, 1e-8, 1e-3, 0.5, 1 - 1e-16, 1.0, 1 + 1e-15, 1.57, np.pi / 2, 3.0]
HUGE = [40.0, 699.0, 701.0, 1e8, 1e155, 1e300, 1.7e308]
SMOOTH = "sqrt exp expm1 log log1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf erfinv fabs sign"
ELEMENTARY: dict[str, Callable[[ca.SX], ca.SX]] = {
    **{name: getattr(ca, name) for name in SMOOTH.split(" ")},
    "inverse": lambda a: 1 / a,
    "square": lambda a: a**2,
    "cube": lambda a: a**3,
    "power 2.5": lambda a: a**2.5,
    "power 0.4": lambda a: a**0.4,
    "power −1.5": lambda a: a**-1.5,
    "power 151": lambda a: a**151,
    "logistic": lambda a: 1 / (1 + ca.exp(-a)),
    "quotient of ones": lambda a: a / a,
    "saturated exponential": lambda a: ca.fmin(ca.exp(a), 3) + ca.tanh(a**3) + ca.atan2(ca.exp(a), 2),
    "saturated": lambda a: ca.fmax(ca.fmin(a, 5), -5),
}


@pytest.mark.parametrize("name", ELEMENTARY)
def test_balls_hold_at_the_edges_of_every_domain(name: str) -> None:
    """Next to poles, branch points, signed zeros, the least and the largest numbers: enclosed, or not known."""
    expression = ELEMENTARY[name](x[0])
    ball, value = enclosed(expression), ca.Function("value", [x], [expression])
    share = np.linspace(-1, 1, 41)
    for at in (sign * size for size in EDGES + HUGE for sign in (1.0, -1.0)):
        for reach in (0.0, 1e-300, 1e-17, 1e-9, 1e-3, 0.3, 1.0, 2.0, 800.0, 1e200):
            centre, size, known = ball(np.array([at, 0.0]), np.array([reach, 0.0]))
            if not known:
                continue
            near = at + reach * share
            near = near[np.abs(near - at) <= reach]
            if name == "sqrt":  # what rounding puts just below zero counts as zero
                near = np.maximum(near, 0.0)
            values = value(np.vstack((near, np.zeros(near.size)))).full().ravel()
            slack = 1e-12 * (1 + np.abs(values).max()) + (1e-7 if abs(abs(at) - 1) < 1e-9 else 0.0)
            assert np.isfinite(values).all(), (at, reach)
            assert np.abs(values - centre).max() <= size + slack, (at, reach)


def test_an_affine_function_s_ball_is_as_small_as_can_be() -> None:
    size = enclosed(3 * x[0] - 2 * x[1] + 5)(np.ones(2), np.array([0.1, 0.2]))[1]

    assert size == pytest.approx(0.3 + 2 * 0.2)


@pytest.mark.parametrize(
    ("expression", "inside", "outside"),
    [
        (1 / x[0], 0.51, 0.5),
        (x[1] / x[0], -0.51, -0.5),
        (ca.log(x[0]), 0.51, 0.5),
        (ca.log1p(x[0]), -0.49, -0.5),
        (ca.sqrt(x[0]), 0.5, 0.49),
        (ca.tan(x[0]), np.pi / 2 - 0.51, np.pi / 2 - 0.49),
        (ca.tan(x[0]), 21 * np.pi / 2 - 0.51, 21 * np.pi / 2 - 0.49),
        (ca.asin(x[0]), 0.49, 0.51),
        (ca.acos(x[0]), -0.49, -0.51),
        (ca.atanh(x[0]), 0.49, 0.51),
        (ca.erfinv(x[0]), 0.49, 0.51),
        (ca.acosh(x[0]), 1.51, 1.49),
        (x[0] ** 1.5, 0.5, 0.49),
        (x[0] ** -3, 3.0, 0.5),
        (x[0] ** -103, -0.51, -0.5),
        (x[0] ** x[1], 0.51, 0.5),
        (ca.exp(x[0]), 689.4, 689.6),
        (ca.exp(-ca.exp(x[0])), 689.4, 689.6),
        (ca.expm1(x[0]), 689.4, 689.6),
        (ca.atan2(x[1], x[0]), 0.51, 0.49),
        (x[0] ** 3, 1e99, 1e101),
        (ca.tanh(x[0] ** 3), 1e99, 1e103),
    ],
)
def test_where_the_function_ends_nothing_is_known(expression: ca.SX, inside: float, outside: float) -> None:
    ball, reach = enclosed(expression), np.array([0.5, 0.0])

    assert ball(np.array([inside, 0.0]), reach)[2] == 1.0
    assert ball(np.array([outside, 0.0]), reach)[2] == 0.0


def test_the_cut_of_a_direction_is_not_crossed() -> None:
    ball, reach = enclosed(ca.atan2(x[1], x[0])), np.array([0.2, 0.2])

    assert [ball(np.array([-1.0, y]), reach)[2] for y in (0.3, 0.1, -0.1, -0.3)] == [1.0, 0.0, 0.0, 1.0]


def test_a_sum_of_squares_has_a_root_everywhere() -> None:
    centre, size, known = enclosed(ca.norm_2(x))(np.array([0.03, -0.01]), np.array([0.2, 0.1]))

    assert known == 1.0
    assert centre - size == pytest.approx(0.0, abs=1e-12)


def test_a_branch_asks_only_where_it_may_be_taken() -> None:
    ball = enclosed(ca.if_else(x[0] > 1, ca.log(x[0]), 0))

    assert [ball(np.array([at, 0.0]), np.array([0.3, 0.0]))[2] for at in (-1.0, 0.2, 0.8, 2.0)] == [1.0] * 4
    assert ball(np.array([0.8, 0.0]), np.array([0.9, 0.0]))[2] == 0.0


def test_a_comparison_may_be_either_where_its_sides_can_meet() -> None:
    ball = enclosed(x[0] < 2 * x[1])
    sizes = [ball(np.array([at, 1.0]), np.array([0.1, 0.2]))[1] for at in (2.4, 2.6, 1.6, 1.4, -2.0)]

    assert sizes == [0.5, 0.0, 0.5, 0.0, 0.0]


@pytest.mark.parametrize("operation", [ca.logic_and, ca.logic_or])
def test_of_two_conditions_one_that_may_be_either_is_enough(operation: Operation) -> None:
    ball, undecided = enclosed(operation(x[0] > 0, x[1] > 0)), operation is ca.logic_or
    other = -1.0 if undecided else 1.0

    assert [ball(np.array(at), np.full(2, 0.1))[1] for at in ([0.05, other], [other, -0.05], [0.05, 0.0])] == [0.5] * 3
    assert ball(np.array([0.05, -other]), np.full(2, 0.1))[:2] == (float(undecided), 0.0)


def test_a_kink_s_slope_is_all_between_both_sides() -> None:
    """CasADi's own derivative of fmin is a quotient of truth values, ½ where both sides are equal."""
    ball = enclosed(ca.gradient(ca.fmin(3 * x[0], x[0]), x)[0])

    assert [ball(np.array([at, 0.0]), np.array([0.1, 0.0]))[:2] for at in (1.0, 0.0, -1.0)] == [(1, 0), (2, 2), (3, 0)]
    at_rest = enclose(ca.gradient(ca.fmin(3 * x[0], x[0]), x)[0], x, ca.SX.zeros(2))
    assert [float(part) for part in ca.Function("ball", [x], list(at_rest))([0, 0])] == [2.0, 0.0, 1.0]


def test_other_quotients_of_truth_values_are_no_slopes() -> None:
    near, above = ca.le(x[0], x[1]), ca.le(x[1], 3)
    odd = [near / (near + above), near / (near + 1), near / (above + 1)]
    ball = [enclosed(expression)(np.zeros(2), np.full(2, 1e-3)) for expression in odd]

    assert [known for _, _, known in ball] == [1.0, 1.0, 1.0]


def test_other_symbols_stay_where_they_are() -> None:
    p = ca.SX.sym("p")
    ball = enclose(p * x[0], x, ca.SX([0.5, 0.0]))

    assert float(ca.Function("radius", [x, p], [ball.radius])([1.0, 0.0], 4.0)) == 2.0


def test_functions_of_what_stays_are_points_where_defined() -> None:
    p = ca.SX.sym("p")
    ball = enclose(ca.vertcat(1 / p, ca.sign(p), ca.if_else(p < 1, 2, 3)), x, ca.SX([0.5, 0.0]))
    values = ca.Function("ball", [p], list(ball))

    assert [part.full().ravel().tolist() for part in values(4.0)] == [[0.25, 1.0, 3.0], [0.0] * 3, [1.0]]
    assert [part.full().ravel().tolist() for part in values(0.0)] == [[0.0] * 3, [0.0] * 3, [0.0]]


def test_an_operation_without_a_derivative_is_named() -> None:
    with pytest.raises(DesignError, match="the operation ceil"):
        enclose(ca.ceil(x[0]), x, ca.SX([0.1, 0.1]))
