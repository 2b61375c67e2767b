"""Enclosures of expressions: a centre and a radius for every value that an expression takes while its symbols move.

Midpoint–radius arithmetic (Rump 1999; Moore, Kearfott & Cloud 2009, chapter 2) on CasADi's scalar graphs. The result
is itself an expression, so that a bound over a whole period is evaluated as fast as the function itself. Radii are
exact in real arithmetic; rounding, of the order of 1e-16 of the values, is not accounted for.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import NamedTuple

import casadi as ca

from passafe.enclosure_rules import RULES
from passafe.enclosure_rules.ball import LARGEST, Ball
from passafe.enclosure_rules.kinks import share
from passafe.errors import DesignError


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


class _Instruction(NamedTuple):
    """One operation of a graph and the instructions that its arguments come from."""

    operation: int
    arguments: tuple[int, ...]


def enclose(expression: ca.SX, symbols: ca.SX, radius: ca.SX) -> Enclosure:
    """Return what the expression can be near its present value: centre, radius, and whether they are known.

    Args:
        expression: Column of scalars, shape (k, 1).
        symbols: Symbols that move, shape (n, 1); all others stay.
        radius: By how much each of them may differ from its present value, expression, shape (n, 1).

    Raises:
        DesignError: The expression has an operation without a derivative.
    """
    fixed = [s for s in ca.symvar(expression) if not any(ca.is_equal(s, moving) for moving in ca.vertsplit(symbols))]
    function = ca.Function("enclosed", [symbols, ca.vertcat(ca.SX(0, 1), *fixed)], [ca.densify(expression)])
    zero = ca.SX(0)
    given = [
        [Ball(symbols[i], radius[i]) for i in range(symbols.numel())],
        [Ball(symbol, zero) for symbol in fixed],
    ]
    return _guarded(_outputs(function, given, expression.numel()))


def _outputs(function: ca.Function, given: Sequence[Sequence[Ball]], count: int) -> list[Ball]:
    """Return the balls of a function's outputs, for those of its inputs."""
    balls: list[Ball] = []
    graph: list[_Instruction] = []
    made_by: dict[int, int] = {}
    outputs = [Ball(ca.SX(0), ca.SX(0))] * count
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[writes[1]] = balls[made_by[reads[0]]]
            continue
        if operation == ca.OP_INPUT:
            graph.append(_Instruction(operation, ()))
            balls.append(given[reads[0]][reads[1]])
        elif operation == ca.OP_CONST:
            graph.append(_Instruction(operation, ()))
            balls.append(Ball(ca.SX(function.instruction_constant(k)), ca.SX(0)))
        else:
            graph.append(_Instruction(operation, tuple(made_by[place] for place in reads)))
            balls.append(_applied(graph, balls))
        made_by[writes[0]] = len(graph) - 1
    return outputs


def _applied(graph: Sequence[_Instruction], balls: Sequence[Ball]) -> Ball:
    """Return the ball of the last instruction, with all conditions that it rests on."""
    operation, arguments = graph[-1]
    other = _other_of_a_tie(graph)
    if other is not None:
        arguments = (arguments[0], other)
        ball = share(*(balls[i] for i in arguments))
    else:
        ball = _rule_of(operation)(*(balls[i] for i in arguments))
    inherited = balls[arguments[0]].conditions
    if operation != ca.OP_IF_ELSE_ZERO:
        inherited = tuple(condition for i in arguments for condition in balls[i].conditions)
    unique = {condition.element_hash(): condition for condition in (*inherited, *ball.conditions)}
    return ball._replace(conditions=tuple(unique.values()))


def _rule_of(operation: int) -> Callable[..., Ball]:
    rule = RULES.get(operation)
    if rule is None:
        name = next(name for name, number in vars(ca).items() if name.startswith("OP_") and number == operation)
        raise DesignError("enclosure", f"the operation {name[3:].lower()}", "operations that have a derivative")
    return rule


def _other_of_a_tie(graph: Sequence[_Instruction]) -> int | None:
    """Return b ≤ a, if the last instruction is (a ≤ b)/((a ≤ b) + (b ≤ a)), CasADi's derivative of an extreme."""
    operation, arguments = graph[-1]
    if operation != ca.OP_DIV:
        return None
    chosen, total = arguments
    if graph[total].operation != ca.OP_ADD or chosen not in graph[total].arguments:
        return None
    other = next((i for i in graph[total].arguments if i != chosen), chosen)
    swapped = _Instruction(ca.OP_LE, graph[other].arguments[::-1])
    return other if graph[other].operation == ca.OP_LE and graph[chosen] == swapped else None


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
