"""Every operation evaluated with numpy, against CasADi."""

import casadi as ca
import numpy as np
import pytest
from passafe_services.tools.review.elementwise import Elementwise

COLUMNS = 64
a, b = ca.SX.sym("a"), ca.SX.sym("b")

EXPRESSIONS = {
    "neg": -a,
    "exp": ca.exp(a),
    "log": ca.log(a),
    "sqrt": ca.sqrt(a),
    "sq": a * a,
    "twice": 2 * a,
    "sin": ca.sin(a),
    "cos": ca.cos(a),
    "tan": ca.tan(a),
    "asin": ca.asin(a / 10),
    "acos": ca.acos(a / 10),
    "atan": ca.atan(a),
    "not": ca.logic_not(a > 0),
    "floor": ca.floor(a),
    "ceil": ca.ceil(a),
    "fabs": ca.fabs(a),
    "sign": ca.sign(a),
    "inv": 1 / a,
    "sinh": ca.sinh(a),
    "cosh": ca.cosh(a),
    "tanh": ca.tanh(a),
    "log1p": ca.log1p(a),
    "expm1": ca.expm1(a),
    "add": a + b,
    "sub": a - b,
    "mul": a * b,
    "div": a / b,
    "pow": a**b,
    "constpow": a**3.5,
    "lt": a < b,
    "le": a <= b,
    "eq": a == b,
    "ne": a != b,
    "and": ca.logic_and(a > 0, b > 0),
    "or": ca.logic_or(a > 0, b > 0),
    "fmin": ca.fmin(a, b),
    "fmax": ca.fmax(a, b),
    "copysign": ca.copysign(a, b),
    "atan2": ca.atan2(a, b),
    "hypot": ca.hypot(a, b),
    "if_else": ca.if_else(a > b, a, 2 * b),
    "constant": ca.SX(3),
}


@pytest.fixture
def samples() -> tuple[np.ndarray, np.ndarray]:
    """Numbers of both signs, equal ones, and what is no number."""
    random = np.random.default_rng(2)
    first, second = random.normal(scale=3, size=(2, 1, COLUMNS))
    second[0, :4] = first[0, :4]
    first[0, -3:], second[0, -2:] = (np.nan, np.inf, 0.0), (np.nan, 0.0)
    return first, second


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_an_operation_gives_what_casadi_gives(name: str, samples: tuple[np.ndarray, np.ndarray]) -> None:
    function = Elementwise(name, [a, b], ca.vertcat(EXPRESSIONS[name], a))

    found, expected = function(*samples), function.function(*samples).full()

    assert function._steps is not None
    assert found.shape == (2, COLUMNS)
    assert np.array_equal(found[1], samples[0][0], equal_nan=True)
    assert found[0] == pytest.approx(expected[0], rel=1e-14, nan_ok=True)


def test_an_operation_that_is_not_known_is_left_to_casadi(samples: tuple[np.ndarray, np.ndarray]) -> None:
    function = Elementwise("erf", [a, b], ca.erf(a) + b)

    assert function._steps is None
    assert function(*samples) == pytest.approx(function.function(*samples).full(), nan_ok=True)


def test_nothing_to_evaluate_has_no_rows(samples: tuple[np.ndarray, np.ndarray]) -> None:
    assert Elementwise("none", [a, b], ca.SX(0, 1))(*samples).shape == (0, COLUMNS)
