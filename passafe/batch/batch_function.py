"""CasADi functions evaluated for many elements of a batch at once, with NumPy arrays in the place of numbers.

A function's scalar operations are applied one by one, each to all elements, in the order of CasADi's own
evaluation. So an element's results do not depend on its neighbours, and sums, products, quotients and roots are the
same to the last bit (IEEE 754); other operations are the same up to rounding. The more elements, the
less of the cost of calling an operation falls on each: at a thousand, it takes a tenth of what CasADi takes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Final, Self

import casadi as ca
import numpy as np

from passafe.batch.array_operations import OPERATIONS, Operation, known_operations, unknown_operation
from passafe.errors import DesignError
from passafe.numerics.workspace import Array

VECTOR: Final = 8
"""Numbers that a processor takes at a time, at most: arrays hold a multiple of it, so that none is left over at their
end and rounded in another way."""


def whole_vectors(elements: int) -> int:
    """Return the number of elements to make room for, so that they fill whole vectors of the processor."""
    return -(-elements // VECTOR) * VECTOR


class BatchFunction:
    """Evaluates one CasADi function for batches: tied to arrays (``bind``), or called with arrays of any length.

    Attributes:
        function: The function.
        is_vectorised: Whether arrays know all of its operations; if not, CasADi evaluates it.
    """

    def __init__(self, function: ca.Function, *, by_casadi: bool = False) -> None:
        """Read the function's operations.

        Args:
            function: Function of scalar expressions (SX), its inputs dense column vectors, its outputs dense.
            by_casadi: Whether CasADi shall evaluate a function with an operation that arrays do not know, rather than
                that it is refused.

        Raises:
            DesignError: The function has an operation that arrays do not know.
        """
        self.function = function
        unknown = unknown_operation(function)
        if unknown and not by_casadi:
            raise DesignError("batch", f"the operation {unknown}", ", ".join(known_operations()))
        self.is_vectorised = not unknown
        self._program = None if unknown else _Program.of(function)

    def bind(self, arguments: Sequence[Array], results: Sequence[Array]) -> Callable[[], None]:
        """Tie the function to arrays and return what evaluates it for all of their columns.

        Args:
            arguments: Array read for each input, shape (size of the input, count).
            results: Array written for each output, shape (size of the output, count), a matrix column by column; none
                of them is an argument.
        """
        if self._program is None:
            return self._bind_casadi(arguments, results)
        steps = self._program.bound(arguments, results)

        def evaluate() -> None:
            with np.errstate(all="ignore"):  # a NaN stays one, as in CasADi
                for operation, operands in steps:
                    operation(*operands)

        return evaluate

    def __call__(self, *arguments: Array) -> tuple[Array, ...]:
        """Return the results for any number of columns.

        Args:
            arguments: For each input an array of shape (size of the input, columns).

        Returns:
            For each output an array of shape (size of the output, columns), a matrix column by column.
        """
        columns, function = arguments[0].shape[1], self.function
        count = whole_vectors(columns)
        padded = [_padded(array, count) for array in arguments]
        results = [np.empty((function.numel_out(i), count)) for i in range(function.n_out())]
        self.bind(padded, results)()
        return tuple(result[:, :columns] for result in results)

    def _bind_casadi(self, arguments: Sequence[Array], results: Sequence[Array]) -> Callable[[], None]:
        shapes = [self.function.size_out(i) for i in range(self.function.n_out())]

        def evaluate() -> None:
            found = self.function.call([ca.DM(array) for array in arguments])
            for array, values, (rows, columns) in zip(results, found, shapes, strict=True):
                side_by_side = values.full().reshape(rows, array.shape[1], columns)
                array[:] = side_by_side.transpose(2, 0, 1).reshape(array.shape)

        return evaluate


def _padded(array: Array, count: int) -> Array:
    """Return an array with columns of zeros after its own, up to a number of columns."""
    if array.shape[1] == count:
        return array
    padded = np.zeros((array.shape[0], count))
    padded[:, : array.shape[1]] = array
    return padded


@dataclass(frozen=True, kw_only=True, slots=True)
class _Program:
    """A function's operations, which read and write numbered rows.

    The first rows are the arguments' elements, then come constants, the results' elements, and rows for passing values.

    Attributes:
        given: Argument and element of each of the first rows.
        constants: Numbers of the next ones.
        written: Result and element of the next ones.
        passing: How many rows there are for passing values.
        steps: Operation, and what takes the rows that it reads and, last, the one that it writes out of all rows.
    """

    given: Sequence[tuple[int, int]]
    constants: Sequence[Array]
    written: Sequence[tuple[int, int]]
    passing: int
    steps: Sequence[tuple[Operation, Callable[[Sequence[Array]], tuple[Array, ...]]]]

    @classmethod
    def of(cls, function: ca.Function) -> Self:
        """Read a function's instructions."""
        given: dict[int, tuple[int, int]] = {}
        constants: dict[int, float] = {}
        calls: list[tuple[Operation, tuple[int, ...], int]] = []
        outputs: list[tuple[int, tuple[int, int]]] = []
        present: dict[int, int] = {}  # which value is in each of CasADi's places
        for value in range(function.n_instructions()):
            number = function.instruction_id(value)
            reads, writes = function.instruction_input(value), function.instruction_output(value)
            if number == ca.OP_OUTPUT:
                outputs.append((present[reads[0]], (writes[0], writes[1])))
                continue
            if number == ca.OP_INPUT:
                given[value] = reads[0], reads[1]
            elif number == ca.OP_CONST:
                constants[value] = function.instruction_constant(value)
            else:
                calls.append((OPERATIONS[number], tuple(present[place] for place in reads), value))
            present[writes[0]] = value
        row_of = {value: row for row, value in enumerate((*given, *constants))}
        steps, passing = _steps(calls, [value for value, _ in outputs], row_of)
        return cls(
            given=[*given.values()],
            constants=[np.array(constant) for constant in constants.values()],
            written=[place for _, place in outputs],
            passing=passing,
            steps=[(operation, itemgetter(*rows)) for operation, rows in steps],
        )

    def bound(self, arguments: Sequence[Array], results: Sequence[Array]) -> list[tuple[Operation, tuple[Array, ...]]]:
        """Return operations with the arrays that each reads and, last, writes."""
        count = arguments[0].shape[1]
        rows = [arguments[i][j] for i, j in self.given]
        rows += self.constants
        rows += [results[i][j] for i, j in self.written]
        rows += [np.empty(count) for _ in range(self.passing)]
        return [(operation, take(rows)) for operation, take in self.steps]


def _steps(
    calls: Sequence[tuple[Operation, tuple[int, ...], int]], outputs: Sequence[int], row_of: dict[int, int]
) -> tuple[list[tuple[Operation, tuple[int, ...]]], int]:
    """Return operations on rows from operations on values, each written once, and how many passing rows they need.

    Args:
        calls: Operation, the values that it reads, and the one that it writes.
        outputs: Value of every result's element.
        row_of: Row of every argument's element and constant; completed.
    """
    fixed = frozenset(row_of)
    first_output = len(row_of)
    first_passing = first_output + len(outputs)
    at_once = {value: first_output + k for k, value in reversed([*enumerate(outputs)]) if value not in fixed}
    last = {value: k for k, (_, reads, _) in enumerate(calls) for value in reads}
    free: list[int] = []
    passing = 0
    steps: list[tuple[Operation, tuple[int, ...]]] = []
    for k, (operation, reads, written) in enumerate(calls):
        if written in at_once:
            row_of[written] = at_once[written]
        elif free:
            row_of[written] = free.pop()
        else:
            row_of[written] = first_passing + passing
            passing += 1
        steps.append((operation, (*(row_of[value] for value in reads), row_of[written])))
        # What was read for the last time makes room for others; not for this result, which may be written in parts.
        free += [
            row_of[value] for value in set(reads) if last[value] == k and value not in fixed and value not in at_once
        ]
    copies = [(row_of[value], first_output + k) for k, value in enumerate(outputs)]
    steps += [(OPERATIONS[ca.OP_ASSIGN], (source, place)) for source, place in copies if source != place]
    return steps, passing
