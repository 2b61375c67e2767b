"""The cuts of angles: where atan2 jumps by a full turn, which none of its derivatives shows."""

import casadi as ca

from passafe.enclosures.enclosure import enclose
from passafe.expressions.expression_graph import graph_of


def apart_from_cuts(value: ca.SX, symbols: ca.SX, radius: ca.SX) -> ca.SX:
    """Return 1 where no angle in an expression is at its cut within reach, else 0, scalar.

    Bounds of a rate bound the change of a function that is continuous; one of an angle, ``atan2(y, x)``, jumps where
    y changes its sign at x < 0.

    Args:
        value: The function, a column of scalars.
        symbols: Symbols that move, shape (n, 1).
        radius: By how much each of them moves at most, expression, shape (n, 1).
    """
    operations = graph_of(value).operations
    angles = [operation.expression for operation in operations if operation.number == ca.OP_ATAN2]
    return enclose(ca.vertcat(*angles), symbols, radius).known if angles else ca.SX(1)
