from collections.abc import Callable
from math import inf, nan

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from passafe.class_k import ClassK, Cubic, Linear, Piecewise
from passafe.errors import DesignError

SHAPES: dict[str, Callable[[float], ClassK]] = {
    "linear": lambda gain: Linear(gain=gain),
    "cubic": lambda gain: Cubic(gain=gain),
    "piecewise": lambda gain: Piecewise(gain=gain, gain_below=3 * gain),
}
gains = st.floats(1e-3, 1e3)
values = st.floats(-1e3, 1e3)


def value(gamma: ClassK, s: float) -> float:
    symbol = ca.SX.sym("s")
    return float(ca.Function("gamma", [symbol], [gamma(symbol)])(s))


@pytest.mark.parametrize(
    ("gamma", "expected"),
    [
        (Linear(gain=2.5), {-2.0: -5.0, 0.0: 0.0, 4.0: 10.0}),
        (Cubic(gain=0.5), {-2.0: -4.0, 0.0: 0.0, 4.0: 32.0}),
        (Piecewise(gain=2.0, gain_below=7.0), {-2.0: -14.0, 0.0: 0.0, 4.0: 8.0}),
    ],
)
def test_values(gamma: ClassK, expected: dict[float, float]) -> None:
    assert {s: value(gamma, s) for s in expected} == expected


@pytest.mark.parametrize("shape", SHAPES)
@given(gain=gains, s=values, t=values)
def test_strictly_increasing_through_zero(shape: str, gain: float, s: float, t: float) -> None:
    gamma = SHAPES[shape](gain)
    low, high = sorted((s, t))

    assert value(gamma, 0.0) == 0.0
    assert value(gamma, low) <= value(gamma, high)
    if high - low > 1e-3:
        assert value(gamma, low) < value(gamma, high)


@given(gain=gains, below=gains)
def test_piecewise_is_continuous_at_zero(gain: float, below: float) -> None:
    gamma = Piecewise(gain=gain, gain_below=below)

    assert value(gamma, 1e-9) == pytest.approx(gain * 1e-9)
    assert value(gamma, -1e-9) == pytest.approx(-below * 1e-9)


@pytest.mark.parametrize("gain", [0.0, -1.0, inf, nan])
@pytest.mark.parametrize("shape", SHAPES)
def test_gains_that_give_no_class_k_function_are_refused(shape: str, gain: float) -> None:
    with pytest.raises(DesignError) as refused:
        SHAPES[shape](gain)

    assert str(refused.value) == f"class-K function gain: got {gain}, allowed a positive finite number"


@pytest.mark.parametrize("gain", [0.0, -1.0, inf, nan])
def test_slopes_below_zero_are_judged_too(gain: float) -> None:
    with pytest.raises(DesignError) as refused:
        Piecewise(gain=1.0, gain_below=gain)

    assert str(refused.value) == f"class-K function gain_below: got {gain}, allowed a positive finite number"
