"""Error of an expression that is computed in floating point, of values that are themselves known to within an error.

To first order, an operation z = f(a, b) passes on |∂f/∂a| and |∂f/∂b| of the errors of its operands and adds half a
unit in the last place of z: running error analysis (Wilkinson 1986; Higham 2002, section 3.3), symbolically, so that it
is evaluated like the expression itself.
"""

from collections.abc import Sequence
from sys import float_info
from typing import Final, NamedTuple

import casadi as ca

ROUNDING: Final = 4 * float_info.epsilon
"""Relative error of one operation: eight times half a unit in the last place, for functions that round more than once
and for what the first order leaves out."""


class _Computed(NamedTuple):
    value: ca.SX
    error: ca.SX


def rounding_error(expression: ca.SX, symbols: ca.SX, errors: ca.SX) -> ca.SX:
    """Return a bound of the error of every entry of a column, of its shape.

    Args:
        expression: Column of scalars, shape (k, 1).
        symbols: Everything that it depends on, shape (n, 1).
        errors: By how much each of them may be wrong, shape (n, 1).
    """
    function = ca.Function("computed", [symbols], [ca.densify(expression)])
    work: dict[int, _Computed] = {}
    found = [ca.SX(0)] * expression.numel()
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_INPUT:
            work[writes[0]] = _Computed(symbols[reads[1]], errors[reads[1]])
        elif operation == ca.OP_CONST:
            work[writes[0]] = _Computed(ca.SX(function.instruction_constant(k)), ca.SX(0))
        elif operation == ca.OP_OUTPUT:
            found[writes[1]] = work[reads[0]].error
        else:
            work[writes[0]] = _applied(operation, [work[place] for place in reads])
    return ca.vertcat(ca.SX(0, 1), *found)


def _applied(operation: int, operands: Sequence[_Computed]) -> _Computed:
    symbols = [ca.SX.sym("operand") for _ in operands]
    apply = ca.SX.unary if len(symbols) == 1 else ca.SX.binary
    result = apply(operation, *symbols)
    slopes = ca.jacobian(result, ca.vertcat(*symbols))
    values = [operand.value for operand in operands]
    value, *passed_on = ca.substitute([result, *(slopes[i] for i in range(len(symbols)))], symbols, values)
    error = ROUNDING * ca.fabs(value)
    for slope, operand in zip(passed_on, operands, strict=True):
        error += ca.fabs(slope) * operand.error
    return _Computed(value, error)
