"""Search for kinks at which an expression has no slope, by numbers.

A kink of a part need not be one of the whole: v·|v| has a slope everywhere, and the largest exponent that logsumexp
subtracts cancels. So points on every kink are found by Newton's method from many starts, and value and gradient are
compared on both sides.
"""

from collections.abc import Iterator, Mapping
from typing import Final

import casadi as ca
import numpy as np

from passafe.expressions.expression_graph import Graph, Operation, graph_of
from passafe.numerics.fixed_order import inner
from passafe.numerics.workspace import Array

STEPS: Final = (1e-6, 1e-7)
"""Distances from the kink, relative to 1 + the point's size: a jump is what is left as they shrink."""

JUMP: Final = 1e-7
"""Jump from which on it is none of rounding, relative to 1 + the value's size."""

SCALES: Final = (0.1, 1.0, 10.0, 100.0)
STARTS: Final = 8
NEWTON_STEPS: Final = 60
ON_THE_KINK: Final = 1e-12

KINKS: Final[Mapping[int, bool]] = {ca.OP_FMIN: True, ca.OP_FMAX: True, ca.OP_FABS: False}
"""Operations with a kink: where both arguments are equal, or where the only one is zero."""

BREAKS: Final[Mapping[int, bool]] = {**KINKS, ca.OP_LE: True, ca.OP_LT: True, ca.OP_SIGN: False, ca.OP_COPYSIGN: False}
"""Operations with a kink or a jump, of which the derivatives of kinks are made."""


def broken_at(expression: ca.SX, moving: ca.SX | None = None, *, by_value: bool = False) -> Operation | None:
    """Return the operation at whose kink an expression's value or slope jumps; None if it has a slope everywhere.

    Args:
        expression: Scalar.
        moving: Symbols in which it is differentiated; all that it has if not given. A kink in others does not count.
        by_value: Whether only jumps of the value count.
    """
    graph = graph_of(expression)
    breaks = [operation for operation in graph.operations if operation.number in BREAKS]
    if not breaks:
        return None
    symbols = ca.vertcat(*ca.symvar(expression))
    moving = symbols if moving is None else moving
    seen = expression if by_value else ca.vertcat(expression, ca.gradient(expression, moving))
    sides = ca.Function("sides", [symbols], [ca.densify(seen)])
    moves = np.array([ca.depends_on(moving, symbol) for symbol in ca.vertsplit(symbols)], dtype=float)
    return next((one for one in breaks if _jumps(sides, _distance(graph, one), symbols, moves)), None)


def _distance(graph: Graph, operation: Operation) -> ca.SX:
    """Return what is zero at an operation's kink."""
    first = graph.operations[operation.arguments[0]].expression
    if not BREAKS[operation.number]:
        return first
    return first - graph.operations[operation.arguments[1]].expression


def _jumps(sides: ca.Function, distance: ca.SX, symbols: ca.SX, moves: Array) -> bool:
    return any(_jumps_across(sides, point, normal) for point, normal in _points_on(distance, symbols, moves))


def _points_on(distance: ca.SX, symbols: ca.SX, moves: Array) -> Iterator[tuple[Array, Array]]:
    """Give points where an expression is zero, with its normalized gradient in the symbols that move."""
    function = ca.Function("distance", [symbols], [distance, ca.densify(ca.gradient(distance, symbols))])
    rng = np.random.default_rng(41)
    for scale in SCALES:
        for start in rng.normal(size=(STARTS, symbols.numel())):
            point = scale * start
            for _ in range(NEWTON_STEPS):
                value, slope = (part.full().ravel() for part in function(point))
                slope = slope * moves
                size = inner(slope, slope)
                if not np.isfinite(value[0]) or not np.isfinite(size) or size == 0.0:
                    break
                if abs(value[0]) <= ON_THE_KINK * np.sqrt(size) * (1 + np.abs(point).max()):
                    yield point, slope / np.sqrt(size)
                    break
                point = point - value[0] / size * slope


def _jumps_across(sides: ca.Function, point: Array, normal: Array) -> bool:
    """Return whether value or slope differ on both sides, extrapolated to the kink itself."""
    differences, size = [], 0.0
    for step in STEPS:
        away = step * (1 + np.abs(point).max()) * normal
        above, below = (sides(point + way).full().ravel() for way in (away, -away))
        differences.append(above - below)
        size = float(np.abs(above).max())
    jump = (STEPS[0] * differences[1] - STEPS[1] * differences[0]) / (STEPS[0] - STEPS[1])
    return bool(np.abs(jump).max() > JUMP * (1 + size))
