"""Bound of what an expression's jumps add to its change: those of the slopes of kinks, |v| or fmin(v, 3).

The mean-value form bounds the change of a function that is continuous. One with jumps is taken as a function e(x, s) of
x and of the signs and comparisons s in it: its change is that of e in x, plus Σ sup|∂e/∂sₖ|·|sₖ(τ) − sₖ(0)|. Where no
kink is within reach, no sₖ changes, and nothing is added.
"""

from collections.abc import Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.enclosure import enclose, is_tie
from passafe.expressions.expression_graph import Graph, Rule, graph_of, rebuilt
from passafe.expressions.slopes import BREAKS, KINKS, broken_at

_LOGIC: Final[Mapping[int, Rule]] = {
    ca.OP_IF_ELSE_ZERO: lambda args: args[0] * args[1],
    ca.OP_NOT: lambda args: 1 - args[0],
    ca.OP_AND: lambda args: args[0] * args[1],
    ca.OP_OR: lambda args: args[0] + args[1] - args[0] * args[1],
}


def jump_bound(e: ca.SX, moving: ca.SX, reach: ca.SX, held: ca.SX, held_radius: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return by how much jumps change an expression while its symbols move, scalar, and 1 where that is known, else 0.

    Args:
        e: Scalar.
        moving: Symbols that move, shape (n, 1).
        reach: By how much each of them moves at most, shape (n, 1).
        held: Symbols that stay, at a value that is not known exactly, shape (m, 1).
        held_radius: By how much each of those may differ from its present value, shape (m, 1).
    """
    graph = graph_of(e)
    places = _signs(graph)
    if not places or broken_at(e, moving, by_value=True) is None:
        return ca.SX(0), ca.SX(1)
    now = ca.vertcat(*(graph.operations[place].expression for place in places))
    symbols, radii = ca.vertcat(moving, held), ca.vertcat(reach, held_radius)
    range_ = enclose(now, symbols, radii)
    change = ca.fabs(range_.centre - now) + range_.radius
    s = ca.SX.sym("s", len(places))
    slope = ca.gradient(rebuilt(graph, _arithmetic(graph) | {place: s[i] for i, place in enumerate(places)}), s)
    steepest = enclose(slope, ca.vertcat(symbols, s), ca.vertcat(radii, range_.radius))
    size, known = ca.dot(ca.fabs(steepest.centre) + steepest.radius, change), steepest.known * range_.known
    size, known = ca.substitute([size, known], [s], [range_.centre])
    return size, known


def _arithmetic(graph: Graph) -> dict[int, ca.SX | Rule]:
    """Return choices and logic of truth values as products and sums, which have derivatives."""
    return {i: _LOGIC[operation.number] for i, operation in enumerate(graph.operations) if operation.number in _LOGIC}


def _signs(graph: Graph) -> list[int]:
    """Return the places of signs, comparisons, and CasADi's slopes of extremes, which are made of comparisons."""
    operations = graph.operations
    ties = {place for place, operation in enumerate(operations) if is_tie(operations, operation)}
    inside = {i for place in ties for i in operations[place].arguments}
    breaks = set(BREAKS) - set(KINKS)
    places = {place for place, operation in enumerate(operations) if operation.number in breaks}
    return sorted(ties | (places - inside))
