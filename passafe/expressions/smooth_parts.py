"""Barriers with kinks as smooth parts: h = min over rows of max over branches, with a slope each.

A set {min(a, b) ≥ 0} is kept by keeping a and b, a row each; {max(a, b) ≥ 0} by keeping the one that holds. Sums,
negations, multiples and steadily growing functions are drawn into minima and maxima, where |e| is max(e, −e).
"""

from collections.abc import Callable, Sequence
from functools import reduce
from itertools import product
from typing import Final, TypeAlias

import casadi as ca

from passafe.errors import DesignError
from passafe.expressions.expression_graph import Graph, Operation, graph_of
from passafe.expressions.removable_kinks import without_removable_kinks
from passafe.expressions.slopes import KINKS, broken_at

Rows: TypeAlias = tuple[tuple[ca.SX, ...], ...]
"""Branches of every row: the expression is the least row, and a row its largest branch."""

MOST_PARTS: Final = 64
"""Branches of all rows together."""

_GROWING: Final = frozenset(
    (
        *(ca.OP_SQRT, ca.OP_EXP, ca.OP_EXPM1, ca.OP_LOG, ca.OP_LOG1P, ca.OP_ATAN, ca.OP_ASIN, ca.OP_SINH),
        *(ca.OP_TANH, ca.OP_ASINH, ca.OP_ACOSH, ca.OP_ATANH, ca.OP_ERF, ca.OP_ERFINV, ca.OP_TWICE),
    )
)
"""Functions of one argument that grow wherever they are defined."""


def smooth_parts(part: str, h: ca.SX) -> Rows:
    """Return rows and branches of an expression; one row of one branch, the expression itself, if it is smooth.

    Args:
        part: Name of the part of the design, for messages.
        h: Scalar.

    Raises:
        DesignError: It has a kink inside another function, or is made of too many parts.
    """
    graph = graph_of(h)
    if not any(operation.number in KINKS for operation in graph.operations):
        return ((h,),)
    return _Decomposition(part, graph).rows_of(graph.outputs[0])


class _Decomposition:
    """Takes one expression apart."""

    def __init__(self, part: str, graph: Graph) -> None:
        self._part = part
        self._operations = graph.operations
        self._bent: list[bool] = []
        for operation in graph.operations:
            self._bent.append(operation.number in KINKS or any(self._bent[i] for i in operation.arguments))

    def rows_of(self, place: int) -> Rows:
        """Return the rows of the operation at a place of the graph."""
        operation = self._operations[place]
        if not self._bent[place]:
            return ((operation.expression,),)
        rows = self._of_extreme(operation) or self._of_one_argument(operation)
        if rows is None:
            broken = broken_at(operation.expression)
            if broken is None:
                return ((without_removable_kinks(operation.expression),),)
            rows = self._of_two_arguments(operation)
            if rows is None:
                raise DesignError(self._part, *_kink_inside(broken, operation))
        return self._few(rows)

    def _of_extreme(self, operation: Operation) -> Rows | None:
        if operation.number not in {ca.OP_FMIN, ca.OP_FMAX, ca.OP_FABS}:
            return None
        if operation.number == ca.OP_FABS:
            rows = self.rows_of(operation.arguments[0])
            return self._largest((rows, self._negated(rows)))
        each = [self.rows_of(place) for place in self._same(operation)]
        return tuple(row for rows in each for row in rows) if operation.number == ca.OP_FMIN else self._largest(each)

    def _same(self, operation: Operation) -> list[int]:
        """Return the arguments of nested minima, or maxima, as one list."""
        waiting, found = list(operation.arguments[::-1]), []
        while waiting:
            place = waiting.pop()
            if self._operations[place].number == operation.number:
                waiting.extend(self._operations[place].arguments[::-1])
            else:
                found.append(place)
        return found

    def _of_one_argument(self, operation: Operation) -> Rows | None:
        """Return the rows of a negation or of a multiple by a number."""
        if operation.number == ca.OP_NEG:
            return self._negated(self.rows_of(operation.arguments[0]))
        if operation.number not in {ca.OP_MUL, ca.OP_DIV}:
            return None
        bent, factor = sorted(operation.arguments, key=lambda place: self._operations[place].expression.is_constant())
        number = self._operations[factor].expression
        is_reciprocal = operation.number == ca.OP_DIV and factor == operation.arguments[0]
        if is_reciprocal or not number.is_constant():
            return None
        rows = self.rows_of(bent)
        rows = rows if float(number) > 0 else self._negated(rows)
        size = abs(float(number))
        return _each(rows, lambda e: e * size if operation.number == ca.OP_MUL else e / size)

    def _of_two_arguments(self, operation: Operation) -> Rows | None:
        """Return the rows of a sum, or of a function that grows."""
        if operation.number in _GROWING:
            return _each(self.rows_of(operation.arguments[0]), lambda e: ca.SX.unary(operation.number, e))
        if operation.number not in {ca.OP_ADD, ca.OP_SUB}:
            return None
        first, second = (self.rows_of(place) for place in operation.arguments)
        second = second if operation.number == ca.OP_ADD else self._negated(second)
        self._few(first, second)
        return tuple(tuple(a + b for a, b in product(one, other)) for one, other in product(first, second))

    def _negated(self, rows: Rows) -> Rows:
        """Return −min max = max min of the negated branches, as a minimum of maxima again."""
        return self._largest([tuple((-branch,) for branch in row) for row in rows])

    def _largest(self, each: Sequence[Rows]) -> Rows:
        def larger(one: Rows, other: Rows) -> Rows:
            return self._few(tuple((*a, *b) for a, b in product(one, other)))

        return reduce(larger, each)

    def _few(self, *factors: Rows) -> Rows:
        count = reduce(lambda total, rows: total * sum(len(row) for row in rows), factors, 1)
        if count > MOST_PARTS:
            raise DesignError(
                self._part,
                f"fmin, fmax and fabs that make {count} parts or more",
                f"{MOST_PARTS} parts at most; write a smooth function such as sumsqr(p), or fewer sides",
            )
        return factors[0]


def _each(rows: Rows, function: Callable[[ca.SX], ca.SX]) -> Rows:
    return tuple(tuple(function(branch) for branch in row) for row in rows)


def _kink_inside(kink: Operation, operation: Operation) -> tuple[str, str]:
    return (
        f"{kink.text} inside {operation.text}: a kink, at which h has no slope",
        "sums and multiples of fmin, fmax and fabs of smooth functions; write sqrt(e**2 + 0.01) for fabs(e)",
    )
