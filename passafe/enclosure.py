"""Enclosures of expressions: a centre and a radius for every value that an expression takes while its symbols move.

Midpoint–radius arithmetic (Rump 1999; Moore, Kearfott & Cloud 2009, chapter 2) on CasADi's scalar graphs. The result
is itself an expression, so that a bound over a whole period is evaluated as fast as the function itself. Radii are
exact in real arithmetic; rounding, of the order of 1e-16 of the values, is not accounted for.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

import casadi as ca

from passafe.errors import DesignError

UNKNOWN: Final = 1e30
"""Radius where nothing is known: large but finite, because infinity times zero is NaN."""


class Ball(NamedTuple):
    """All numbers within ``radius`` of ``centre``, both scalar expressions."""

    centre: ca.SX
    radius: ca.SX


Arguments = tuple[Ball, ...]


def enclose(expression: ca.SX, symbols: ca.SX, radius: ca.SX) -> Ball:
    """Return centre and radius, each of the expression's shape (k, 1), of what it can be near its present value.

    Args:
        expression: Column of scalars, shape (k, 1).
        symbols: Symbols that move, shape (n, 1); all others stay.
        radius: By how much each of them may differ from its present value, expression, shape (n, 1).

    Raises:
        DesignError: The expression has an operation without an enclosure.
    """
    fixed = [s for s in ca.symvar(expression) if not any(ca.is_equal(s, moving) for moving in ca.vertsplit(symbols))]
    function = ca.Function("enclosed", [symbols, ca.vertcat(ca.SX(0, 1), *fixed)], [ca.densify(expression)])
    zero = ca.SX(0)
    given = [
        [Ball(symbols[i], radius[i]) for i in range(symbols.numel())],
        [Ball(symbol, zero) for symbol in fixed],
    ]
    work: dict[int, Ball] = {}
    centres, radii = [zero] * expression.numel(), [zero] * expression.numel()
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_INPUT:
            work[writes[0]] = given[reads[0]][reads[1]]
        elif operation == ca.OP_CONST:
            work[writes[0]] = Ball(ca.SX(function.instruction_constant(k)), zero)
        elif operation == ca.OP_OUTPUT:
            centres[writes[1]], radii[writes[1]] = work[reads[0]]
        else:
            work[writes[0]] = _applied(operation, [work[place] for place in reads])
    return Ball(ca.vertcat(*centres), ca.vertcat(*radii))


def _applied(operation: int, arguments: Sequence[Ball]) -> Ball:
    rule = _RULES.get(operation)
    if rule is None:
        got = next((name for name, number in vars(ca).items() if name.startswith("OP_") and number == operation), "")
        known = sorted(name for name in vars(ca) if name.startswith("OP_") and getattr(ca, name) in _RULES)
        raise DesignError("enclosure", f"the operation {got}", ", ".join(known))
    return rule(*arguments)


def _add(a: Ball, b: Ball) -> Ball:
    return Ball(a.centre + b.centre, a.radius + b.radius)


def _subtract(a: Ball, b: Ball) -> Ball:
    return Ball(a.centre - b.centre, a.radius + b.radius)


def _negate(a: Ball) -> Ball:
    return Ball(-a.centre, a.radius)


def _twice(a: Ball) -> Ball:
    return Ball(2 * a.centre, 2 * a.radius)


def _multiply(a: Ball, b: Ball) -> Ball:
    radius = ca.fabs(a.centre) * b.radius + a.radius * ca.fabs(b.centre) + a.radius * b.radius
    return Ball(a.centre * b.centre, radius)


def _square(a: Ball) -> Ball:
    return Ball(a.centre * a.centre, a.radius * (2 * ca.fabs(a.centre) + a.radius))


def _invert(a: Ball) -> Ball:
    """1/a: furthest from the centre's at the end near zero; nothing is known if zero is within reach."""
    if a.radius.is_zero():
        return Ball(1 / a.centre, a.radius)
    size = ca.fabs(a.centre)
    apart = size > a.radius
    room = ca.if_else(apart, size * (size - a.radius), 1)
    return Ball(ca.if_else(apart, 1 / ca.if_else(apart, a.centre, 1), 0), ca.if_else(apart, a.radius / room, UNKNOWN))


def _divide(a: Ball, b: Ball) -> Ball:
    return Ball(a.centre / b.centre, a.radius / ca.fabs(b.centre)) if b.radius.is_zero() else _multiply(a, _invert(b))


def _root(a: Ball) -> Ball:
    """Return √a of a ≥ 0: concave, so furthest from the centre's at the lower end, unless that is cut off at zero."""
    centre = ca.sqrt(a.centre)
    lower, upper = ca.sqrt(ca.fmax(a.centre - a.radius, 0)), ca.sqrt(a.centre + a.radius)
    return Ball(centre, ca.fmax(centre - lower, upper - centre))


def _exponential(a: Ball) -> Ball:
    return Ball(ca.exp(a.centre), ca.exp(a.centre) * (ca.exp(a.radius) - 1))


def _logarithm(a: Ball) -> Ball:
    """Log a: concave, so furthest from the centre's at the lower end; nothing is known if that is not positive."""
    apart = a.centre > a.radius
    low = ca.if_else(apart, a.centre - a.radius, 1)
    centre = ca.log(ca.if_else(apart, a.centre, 1))
    return Ball(centre, ca.if_else(apart, centre - ca.log(low), UNKNOWN))


def _hyperbolic_sine(a: Ball) -> Ball:
    grown = ca.cosh(a.centre) * ca.sinh(a.radius) + ca.fabs(ca.sinh(a.centre)) * (ca.cosh(a.radius) - 1)
    return Ball(ca.sinh(a.centre), grown)


def _hyperbolic_cosine(a: Ball) -> Ball:
    grown = ca.cosh(a.centre) * (ca.cosh(a.radius) - 1) + ca.fabs(ca.sinh(a.centre)) * ca.sinh(a.radius)
    return Ball(ca.cosh(a.centre), grown)


def _never_steeper_than_one(function: Callable[[ca.SX], ca.SX]) -> Callable[[Ball], Ball]:
    return lambda a: Ball(function(a.centre), a.radius)


def _extreme(function: Callable[[ca.SX, ca.SX], ca.SX]) -> Callable[[Ball, Ball], Ball]:
    return lambda a, b: Ball(function(a.centre, b.centre), ca.fmax(a.radius, b.radius))


def _sign(a: Ball) -> Ball:
    return Ball(ca.sign(a.centre), ca.if_else(ca.fabs(a.centre) <= a.radius, 2, 0))


def _compare(function: Callable[[ca.SX, ca.SX], ca.SX]) -> Callable[[Ball, Ball], Ball]:
    """Return a truth value, 0 or 1; its radius is 1 where it may be either."""

    def compared(a: Ball, b: Ball) -> Ball:
        reach = a.radius + b.radius
        open_ = ca.SX(0) if reach.is_zero() else ca.if_else(ca.fabs(a.centre - b.centre) <= reach, 1, 0)
        return Ball(function(a.centre, b.centre), open_)

    return compared


def _not(a: Ball) -> Ball:
    return Ball(1 - a.centre, a.radius)


def _both(a: Ball, b: Ball) -> Ball:
    return Ball(ca.logic_and(a.centre, b.centre), ca.fmax(a.radius, b.radius))


def _either(a: Ball, b: Ball) -> Ball:
    return Ball(ca.logic_or(a.centre, b.centre), ca.fmax(a.radius, b.radius))


def _where(condition: Ball, a: Ball) -> Ball:
    """Return a where the condition holds, else 0; where it may be either, a ball with all of it."""
    centre = ca.if_else(condition.centre, a.centre, 0)
    certain = ca.if_else(condition.centre, a.radius, 0)
    return Ball(centre, ca.if_else(condition.radius > 0, ca.fabs(a.centre) + a.radius, certain))


_RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    ca.OP_ADD: _add,
    ca.OP_SUB: _subtract,
    ca.OP_NEG: _negate,
    ca.OP_TWICE: _twice,
    ca.OP_MUL: _multiply,
    ca.OP_SQ: _square,
    ca.OP_INV: _invert,
    ca.OP_DIV: _divide,
    ca.OP_SQRT: _root,
    ca.OP_EXP: _exponential,
    ca.OP_LOG: _logarithm,
    ca.OP_SINH: _hyperbolic_sine,
    ca.OP_COSH: _hyperbolic_cosine,
    ca.OP_SIN: _never_steeper_than_one(ca.sin),
    ca.OP_COS: _never_steeper_than_one(ca.cos),
    ca.OP_TANH: _never_steeper_than_one(ca.tanh),
    ca.OP_ATAN: _never_steeper_than_one(ca.atan),
    ca.OP_FABS: _never_steeper_than_one(ca.fabs),
    ca.OP_FMIN: _extreme(ca.fmin),
    ca.OP_FMAX: _extreme(ca.fmax),
    ca.OP_SIGN: _sign,
    ca.OP_LT: _compare(ca.lt),
    ca.OP_LE: _compare(ca.le),
    ca.OP_NOT: _not,
    ca.OP_AND: _both,
    ca.OP_OR: _either,
    ca.OP_IF_ELSE_ZERO: _where,
}
