"""Norms in barriers: the same set described by a function that has a slope at the norm's centre too.

√s has no slope at s = 0. Where h = c − k√s with a number k > 0 and c a number or an expression, seen to be positive
whatever the state is, the set {h ≥ 0} is also that of

    (c² − k²s)/(2c) = h − (c − k√s)²/(2c) ≤ h,

which has the same slope on the boundary and no singular point. A norm that stands elsewhere keeps its value, but for
1e-9 at its centre: there the slope is 0 instead of none.
"""

from collections.abc import Sequence
from math import inf
from typing import Final

import casadi as ca

from passafe.expressions.expression_graph import Graph, Rule, graph_of, rebuilt

NEAR: Final = 0.1
"""Least value of k√s, relative to c, from which on it bends no more than the boundary does, about."""

SMALLEST_SQUARE: Final = 1e-18
"""What is added below a root that can be zero."""

_ROOTS: Final = frozenset((ca.OP_SQRT, ca.OP_HYPOT))


def without_singular_points(h: ca.SX) -> ca.SX:
    """Return a scalar with the sign of h whose norms have a slope everywhere; h itself if it has no norms."""
    graph = graph_of(h)
    for place, operation in enumerate(graph.operations):
        if operation.number in _ROOTS:
            rewritten = _squared(graph, place)
            if rewritten is not None:
                return without_singular_points(rewritten)  # c may contain another norm
    off_centre: dict[int, ca.SX | Rule] = {}
    for place, operation in enumerate(graph.operations):
        if operation.number in _ROOTS and _least_square(graph, place) == 0.0:
            off_centre[place] = _off_centre(operation.number)
    return rebuilt(graph, off_centre) if off_centre else h


def _off_centre(number: int) -> Rule:
    return lambda arguments: ca.sqrt(_square(number, arguments) + SMALLEST_SQUARE)


def _squared(graph: Graph, place: int) -> ca.SX | None:
    """Return (c² − k²s)/(2c) if the expression is c − k√s and can come near s = 0, else None."""
    root = ca.SX.sym("root")
    whole = rebuilt(graph, {place: root})
    slope = ca.jacobian(whole, root)
    if not slope.is_constant():
        return None
    c, k, least = ca.substitute(whole, root, ca.SX(0)), -float(slope), _least_square(graph, place)
    clear = graph_of(c)
    smallest = _least(clear, clear.outputs[0])
    if k <= 0.0 or not 0.0 < smallest < inf or not 0.0 <= least < (NEAR * smallest / k) ** 2:
        return None
    operation = graph.operations[place]
    square = _square(operation.number, [graph.operations[i].expression for i in operation.arguments])
    return (c**2 - k**2 * square) / (2 * c)


def _square(number: int, arguments: Sequence[ca.SX]) -> ca.SX:
    """Return what a norm is the root of."""
    return arguments[0] if number == ca.OP_SQRT else ca.sumsqr(ca.vertcat(*arguments))


def _least_square(graph: Graph, place: int) -> float:
    """Return a lower bound of what a norm is the root of; −∞ if it is no sum of squares and positive numbers."""
    operation = graph.operations[place]
    return 0.0 if operation.number == ca.OP_HYPOT else _least(graph, operation.arguments[0])


def _least(graph: Graph, place: int) -> float:
    operation = graph.operations[place]
    arguments = operation.arguments
    if operation.number == ca.OP_CONST:
        return float(operation.expression)
    if operation.number in {ca.OP_SQ, ca.OP_FABS, ca.OP_EXP, *_ROOTS}:
        return 0.0
    if operation.number == ca.OP_ADD:
        return sum(_least(graph, i) for i in arguments)
    if operation.number == ca.OP_TWICE:
        return 2 * _least(graph, arguments[0])
    if operation.number in {ca.OP_MUL, ca.OP_DIV}:
        ends = [_least(graph, i) for i in arguments]
        return 0.0 if min(ends) >= 0.0 else -inf
    return -inf
