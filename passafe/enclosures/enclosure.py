"""Enclosures of expressions: a centre and a radius for every value that an expression takes while its symbols move.

Midpoint–radius arithmetic (Rump 1999; Moore, Kearfott & Cloud 2009, chapter 2) on CasADi's scalar graphs. The result
is itself an expression, so that a bound over a whole period is evaluated as fast as the function itself. Radii are
exact in real arithmetic; rounding, of the order of 1e-16 of the values, is not accounted for.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import NamedTuple

import casadi as ca

from passafe.enclosures.rules import RULES
from passafe.enclosures.rules.ball import LARGEST, Ball
from passafe.enclosures.rules.kinks import share
from passafe.errors import DesignError
from passafe.expressions.expression_graph import Operation, graph_of, name_of


class Enclosure(NamedTuple):
    """Values that an expression of shape (k, 1) can take.

    Attributes:
        centre: Midpoints, shape (k, 1); not always the present value. Finite wherever the arguments are.
        radius: How far the values may lie from them, shape (k, 1). Finite wherever the arguments are.
        known: 1 where no value lies further away, scalar. 0 where an operation leaves its domain within the radius,
            for example a division by zero, or overflows: there centre and radius mean nothing.
    """

    centre: ca.SX
    radius: ca.SX
    known: ca.SX


def enclose(expression: ca.SX, symbols: ca.SX, radius: ca.SX) -> Enclosure:
    """Return what the expression can be near its present value: centre, radius, and whether they are known.

    Args:
        expression: Column of scalars, shape (k, 1).
        symbols: Symbols that move, shape (n, 1); all others stay.
        radius: By how much each of them may differ from its present value, expression, shape (n, 1).

    Raises:
        DesignError: The expression has an operation without a derivative.
    """
    moving = {symbol.element_hash(): radius[i] for i, symbol in enumerate(ca.vertsplit(symbols))}
    graph = graph_of(expression)
    balls: list[Ball] = []
    for place, operation in enumerate(graph.operations):
        if operation.number in {ca.OP_INPUT, ca.OP_CONST}:
            balls.append(Ball(operation.expression, moving.get(operation.expression.element_hash(), ca.SX(0))))
        else:
            balls.append(_applied(graph.operations, place, balls))
    return _guarded([balls[place] for place in graph.outputs])


def _applied(operations: Sequence[Operation], place: int, balls: Sequence[Ball]) -> Ball:
    """Return the ball of one operation, with all conditions that it rests on."""
    arguments, rule = operations[place].arguments, _rule_of(operations[place].number)
    other = _other_of_a_tie(operations, operations[place])
    if other is not None:
        arguments, rule = (arguments[0], other), share
    ball = rule(*(balls[i] for i in arguments))
    inherited = balls[arguments[0]].conditions
    if operations[place].number != ca.OP_IF_ELSE_ZERO:
        inherited = tuple(condition for i in arguments for condition in balls[i].conditions)
    unique = {condition.element_hash(): condition for condition in (*inherited, *ball.conditions)}
    return ball._replace(conditions=tuple(unique.values()))


def _rule_of(operation: int) -> Callable[..., Ball]:
    rule = RULES.get(operation)
    if rule is None:
        raise DesignError("enclosure", f"the operation {name_of(operation)}", "operations that have a derivative")
    return rule


def _other_of_a_tie(operations: Sequence[Operation], operation: Operation) -> int | None:
    """Return where b ≤ a is, if an operation is (a ≤ b)/((a ≤ b) + (b ≤ a)), CasADi's derivative of an extreme."""
    if operation.number != ca.OP_DIV:
        return None
    chosen, total = operation.arguments
    if operations[total].number != ca.OP_ADD or chosen not in operations[total].arguments:
        return None
    other = sum(operations[total].arguments) - chosen
    both_compare = operations[chosen].number == operations[other].number == ca.OP_LE
    return other if both_compare and operations[chosen].arguments == operations[other].arguments[::-1] else None


def is_tie(operations: Sequence[Operation], operation: Operation) -> bool:
    """Return whether an operation is CasADi's derivative of a minimum or maximum, (a ≤ b)/((a ≤ b) + (b ≤ a))."""
    return _other_of_a_tie(operations, operation) is not None


def _guarded(balls: Sequence[Ball]) -> Enclosure:
    """Return an enclosure whose numbers are finite whatever overflows; bare symbols and numbers cannot."""
    made = [ball for ball in balls if not _is_given(ball)]
    conditions = {condition.element_hash(): condition for ball in balls for condition in ball.conditions}
    if made:
        size = sum((ca.fabs(ball.centre) + ball.radius for ball in made), ca.SX(0))
        conditions[-1] = size < LARGEST
    known = reduce(ca.logic_and, conditions.values(), ca.SX(1))

    def finite(part: ca.SX, ball: Ball) -> ca.SX:
        return part if _is_given(ball) else ca.if_else(known, part, 0)

    centre = ca.vertcat(*(finite(ball.centre, ball) for ball in balls))
    return Enclosure(centre, ca.vertcat(*(finite(ball.radius, ball) for ball in balls)), known)


def _is_given(ball: Ball) -> bool:
    return not ball.conditions and bool(ball.centre.is_constant() or ball.centre.is_symbolic())
