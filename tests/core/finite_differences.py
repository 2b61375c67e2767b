"""Time derivatives along a flow by integrating it a tiny step to both sides: what derived expressions are tested on."""

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
STEP_S = 1e-3


def numeric(arguments: Sequence[ca.SX], expression: ca.SX) -> Callable[..., Array]:
    """Return an expression as a function of plain numbers, with a flat result."""
    function = ca.Function("numeric", [ca.densify(each) for each in arguments], [ca.densify(expression)])
    given = [np.zeros(function.nnz_in(place)) for place in range(function.n_in())]
    result = np.zeros(function.nnz_out(0))
    buffer, run = function.buffer()  # a matrix of CasADi's costs a hundred times as much to make as these to fill
    for place, array in enumerate(given):
        buffer.set_arg(place, memoryview(array))
    buffer.set_res(0, memoryview(result))

    def evaluate(*values: ArrayLike, _kept: object = buffer) -> Array:  # which knows its addresses, and keeps nothing
        for array, value in zip(given, values, strict=True):
            array[:] = np.asarray(value, dtype=float).ravel(order="F")
        run()
        return result.copy()

    return evaluate


def runge_kutta(rate: Callable[[float, Array], Array], t: float, s: Array, h: float) -> Array:
    """Return s after one step of the classical fourth-order method."""
    k1 = rate(t, s)
    k2 = rate(t + h / 2, s + h / 2 * k1)
    k3 = rate(t + h / 2, s + h / 2 * k2)
    k4 = rate(t + h, s + h * k3)
    return s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def rate_along(
    function: Callable[[Array], Array],
    rate: Callable[[float, Array], Array],
    s: ArrayLike,
    step_s: float = STEP_S,
) -> Array:
    """Return d/dt of function(s(t)) at t = 0 along ṡ = rate(t, s), by a fourth-order central difference."""
    s0 = np.asarray(s, dtype=float)
    at = {}
    for sign in (1, -1):
        once = runge_kutta(rate, 0.0, s0, sign * step_s)
        at[sign] = function(once)
        at[2 * sign] = function(runge_kutta(rate, sign * step_s, once, sign * step_s))
    return (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * step_s)


def slope(function: Callable[[Array], float], at: ArrayLike, step: float = 1e-3) -> Array:
    """Return the gradient of a scalar function of a vector, by fourth-order central differences."""
    point = np.asarray(at, dtype=float)
    partial = []
    for axis in np.eye(point.size) * step:
        near = function(point + axis) - function(point - axis)
        far = function(point + 2 * axis) - function(point - 2 * axis)
        partial.append((8 * near - far) / (12 * step))
    return np.array(partial)
