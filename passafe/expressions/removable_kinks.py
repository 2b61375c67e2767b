"""Kinks that cancel: a value that an expression does not depend on, such as the exponent that logsumexp subtracts.

log Σ exp(xᵢ) is written m + log Σ exp(xᵢ − m) with m = max xᵢ so that nothing overflows. The kinks of m are none of the
whole, but they would widen what is known of its derivatives; so m is rounded to a step, which does as well and has the
derivative zero. That is right because the whole does not depend on m, and for no other reason.
"""

from typing import Final

import casadi as ca
import numpy as np

from passafe.expressions.expression_graph import Graph, graph_of, rebuilt
from passafe.expressions.slopes import KINKS

PROBES: Final = 12
"""Points at which the dependence on a kink's value has to vanish."""

CANCELLED: Final = 1e-10
"""Derivative up to which it counts as rounding, relative to 1 + the value's size."""

STEP: Final = 32.0
"""Step to which such a value is rounded: exponentials may be off by e³² in both directions and are still in range."""


def without_removable_kinks(e: ca.SX) -> ca.SX:
    """Return a scalar of the same value in which no kink is left on whose value it does not depend."""
    graph = graph_of(e)
    for place in _in_use(graph):
        if graph.operations[place].number in KINKS and _is_removable(graph, place):
            return without_removable_kinks(rebuilt(graph, {place: _rounded(graph.operations[place].expression)}))
    return e


def _in_use(graph: Graph) -> list[int]:
    """Return the places on which the expression depends other than by what is rounded, the last first."""
    used = set(graph.outputs)
    for place in reversed(range(len(graph.operations))):
        if place in used and graph.operations[place].number != ca.OP_FLOOR:
            used.update(graph.operations[place].arguments)
    return sorted(used, reverse=True)


def _rounded(value: ca.SX) -> ca.SX:
    return STEP * ca.floor(value / STEP)


def _is_removable(graph: Graph, place: int) -> bool:
    """Return whether the expression does not depend on a kink's value, at points in general position."""
    value = ca.SX.sym("value")
    whole = rebuilt(graph, {place: value})
    kink = graph.operations[place].expression
    symbols = ca.vertcat(*ca.symvar(graph.operations[graph.outputs[0]].expression))
    here = ca.Function("here", [symbols], [kink])
    slope = ca.Function("slope", [symbols, value], [whole, ca.jacobian(whole, value)])
    rng = np.random.default_rng(43)
    seen = []
    for point in rng.normal(size=(PROBES, symbols.numel())):
        size, change = (float(part) for part in slope(point, float(here(point)) + rng.normal()))
        seen.append(abs(change) <= CANCELLED * (1 + abs(size)))
    return all(seen)
