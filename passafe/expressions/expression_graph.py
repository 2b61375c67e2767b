"""Expressions as graphs: their operations in the order of evaluation, each with what it is made from."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

import casadi as ca

LONGEST_TEXT: Final = 60
"""Characters of a part's text in a message."""


class Operation(NamedTuple):
    """One operation of an expression.

    Attributes:
        number: CasADi's number of it; ``OP_INPUT`` for a symbol, ``OP_CONST`` for a number.
        arguments: Places of its arguments in the graph; they come before it.
        expression: Itself as an expression, scalar.
    """

    number: int
    arguments: tuple[int, ...]
    expression: ca.SX

    @property
    def text(self) -> str:
        """Itself in CasADi's words, cut where it is long."""
        text = str(self.expression)
        return text if len(text) <= LONGEST_TEXT else f"{text[:LONGEST_TEXT]}…"


class Graph(NamedTuple):
    """Operations of an expression of shape (k, 1), and the places of its k scalars among them."""

    operations: tuple[Operation, ...]
    outputs: tuple[int, ...]


Rule: TypeAlias = Callable[[Sequence[ca.SX]], ca.SX]
"""From an operation's arguments, as they have become, to what stands for it."""


def graph_of(expression: ca.SX) -> Graph:
    """Return the graph of a column of scalars; calls of functions have no expression and end as ``OP_CALL``."""
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(expression))
    function = ca.Function("graph", [symbols], [ca.densify(expression)])
    operations: list[Operation] = []
    made_by: dict[int, int] = {}
    outputs = [0] * expression.numel()
    for k in range(function.n_instructions()):
        number = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if number == ca.OP_OUTPUT:
            outputs[writes[1]] = made_by[reads[0]]
            continue
        if number == ca.OP_INPUT:
            operation = Operation(number, (), symbols[reads[1]])
        elif number == ca.OP_CONST:
            operation = Operation(number, (), ca.SX(function.instruction_constant(k)))
        else:
            arguments = tuple(made_by[place] for place in reads)
            operation = Operation(number, arguments, _applied(number, [operations[i].expression for i in arguments]))
        operations.append(operation)
        for place in writes:
            made_by[place] = len(operations) - 1
    return Graph(tuple(operations), tuple(outputs))


def name_of(number: int) -> str:
    """Return CasADi's name of an operation, in small letters."""
    return next(name for name, value in vars(ca).items() if name.startswith("OP_") and value == number)[3:].lower()


def _applied(number: int, arguments: Sequence[ca.SX]) -> ca.SX:
    if number == ca.OP_CALL:
        return ca.SX.sym(f"function({', '.join(str(argument) for argument in arguments)})")
    return ca.SX.unary(number, *arguments) if len(arguments) == 1 else ca.SX.binary(number, *arguments)


def rebuilt(graph: Graph, instead: Mapping[int, ca.SX | Rule]) -> ca.SX:
    """Return a scalar's expression with some of its operations replaced.

    Args:
        graph: Of a scalar.
        instead: What stands for an operation, by its place.
    """
    expressions: list[ca.SX] = []
    for place, operation in enumerate(graph.operations):
        arguments = [expressions[i] for i in operation.arguments]
        other = instead.get(place)
        if other is None:
            expressions.append(_applied(operation.number, arguments) if arguments else operation.expression)
        else:
            expressions.append(other(arguments) if callable(other) else other)
    return expressions[graph.outputs[0]]
