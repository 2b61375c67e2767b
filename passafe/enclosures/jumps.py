"""Operations that a filter cannot differentiate, because they jump or have no slope, and what to write instead."""

from collections.abc import Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.rules import RULES
from passafe.errors import DesignError
from passafe.expressions.expression_graph import Graph, Operation, graph_of, name_of

_ROUNDING: Final = ("rounding, which jumps", "one barrier for each step, or a smooth function through the same points")
_REMAINDER: Final = ("a remainder, which jumps", "sin and cos of an angle instead of the angle itself")
_SIGN: Final = ("a sign, which jumps at zero", "tanh(k*v) with a large k, or v*fabs(v) where it multiplies v squared")
_CHOICE: Final = (
    "a choice by a condition, which may jump",
    "fmin and fmax for saturations, several barriers for several conditions, a smooth (1 + tanh(k*v))/2 for a switch",
)
_CALL: Final = (
    "a look-up table or another function that is called, not written out",
    "its formula in casadi.SX; for a table a polynomial or a sum of tanh through its points",
)
_JUMPS: Final[Mapping[int, tuple[str, str]]] = {
    ca.OP_FLOOR: _ROUNDING,
    ca.OP_CEIL: _ROUNDING,
    ca.OP_FMOD: _REMAINDER,
    ca.OP_REMAINDER: _REMAINDER,
    ca.OP_SIGN: _SIGN,
    ca.OP_COPYSIGN: _SIGN,
    **dict.fromkeys(
        (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR, ca.OP_IF_ELSE_ZERO), _CHOICE
    ),
    ca.OP_CALL: _CALL,
}
"""By CasADi's number of the operation: what it is, and what to write instead."""

_PLAIN: Final = frozenset((ca.OP_INPUT, ca.OP_CONST, *RULES)) - frozenset(_JUMPS)
"""Operations that have a slope, or kinks at most."""


def require_no_jumps(part: str, expression: ca.SX) -> None:
    """Refuse an expression with an operation that jumps or has no derivative.

    Args:
        part: Name of the part of the design, for the message.
        expression: Column of scalars.

    Raises:
        DesignError: It has one; the message names it, why it is refused, and what to write instead.
    """
    graph = graph_of(expression)
    _refuse_numbers(part, graph)
    # The last one contains the others: of a choice made of comparisons it is the choice itself.
    refused = [
        operation
        for operation in graph.operations
        if operation.number not in _PLAIN and not _has_fixed_sign(operation, graph.operations)
    ]
    if refused:
        name = name_of(refused[-1].number).removesuffix("_zero")
        why, instead = _JUMPS.get(refused[-1].number, ("an operation without a derivative", "elementary functions"))
        raise DesignError(part, f"{name} in {refused[-1].text}, {why}", f"continuous functions; write {instead}")


def require_finite_constants(part: str, expression: ca.SX) -> None:
    """Refuse an expression that is only evaluated if a constant in it is NaN or infinite.

    Args:
        part: Name of the part of the design, for the message.
        expression: Column of scalars.

    Raises:
        DesignError: One is.
    """
    _refuse_numbers(part, graph_of(expression))


def _refuse_numbers(part: str, graph: Graph) -> None:
    for operation in graph.operations:
        if operation.number == ca.OP_CONST and not operation.expression.is_regular():
            raise DesignError(part, f"the number {operation.text}", "finite numbers")


def _has_fixed_sign(operation: Operation, operations: tuple[Operation, ...]) -> bool:
    """Return whether an operation is |a| with the sign of a number, which never changes."""
    return operation.number == ca.OP_COPYSIGN and operations[operation.arguments[1]].number == ca.OP_CONST
