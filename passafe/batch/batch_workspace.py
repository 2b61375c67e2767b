"""Many blocks of numbers side by side, and CasADi functions that are evaluated for all of them at once.

A lane is one block of a ``BlockLayout``. A function's scalar operations are done one after the other, each for all
lanes, in the order of CasADi's own evaluation. So a lane's numbers do not depend on the lanes beside it, and what is
made of sums, products, quotients and roots is the same to the last bit (IEEE 754). The more lanes, the less of the
cost of calling an operation falls on each: at a thousand, it takes a tenth of what CasADi takes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Self, TypeAlias

import casadi as ca
import numpy as np

from passafe.errors import DesignError
from passafe.workspace import Array, BlockLayout

Operation: TypeAlias = Callable[..., object]
"""Reads one or two arrays and writes the last one."""

VECTOR: Final = 8
"""Numbers that a processor takes at a time, at most: lanes are a multiple of it, so that none is left over at their end
and rounded in another way."""


class BatchWorkspace:
    """A ``Workspace`` with many lanes.

    Attributes:
        layout: Names and places of the parts.
        used: Number of lanes that hold something.
        count: Number of lanes, a few more than are used.
        block: The numbers, shape (layout.size, count).
    """

    def __init__(self, layout: BlockLayout, used: int) -> None:
        """Make room.

        Args:
            layout: Parts of every lane.
            used: Number of lanes that are needed.
        """
        self.layout = layout
        self.used = used
        self.count = -(-used // VECTOR) * VECTOR
        self.block: Array = np.zeros((layout.size, self.count))

    def part(self, name: str) -> Array:
        """Return the view of one part, shape (size of the part, count)."""
        return self.block[self.layout.parts[name]]

    def matrix(self, name: str, shape: tuple[int, int]) -> Array:
        """Return the view of one part as matrices of a shape (rows, columns), columns first: (columns, rows, count)."""
        rows, columns = shape
        return self.part(name).reshape(columns, rows, self.count)

    def bind(self, function: ca.Function, arguments: Sequence[str], results: Sequence[str]) -> Callable[[], None]:
        """Tie a function to parts of the lanes and return what evaluates it for all of them.

        Args:
            function: Dense inputs and outputs of the parts' sizes.
            arguments: Part read for each input.
            results: Part written for each output; none of them is an argument.

        Raises:
            DesignError: The function has an operation that arrays do not know.
        """
        program = _Program.of(function)
        read, written = ([self.part(name) for name in names] for names in (arguments, results))
        steps = program.steps(read, written, self.count)

        def evaluate() -> None:
            with np.errstate(all="ignore"):  # what is no number stays none, as in CasADi
                for operation, operands in steps:
                    operation(*operands)

        return evaluate


@dataclass(frozen=True, kw_only=True, slots=True)
class _Program:
    """A function's operations with every value written once.

    Attributes:
        given: Value that each element of an argument is, by (argument, element).
        constants: Values that never change.
        calls: Operation, the values that it reads, and the one that it writes.
        outputs: Value and the element (result, element) that it is.
    """

    given: Mapping[int, tuple[int, int]]
    constants: Mapping[int, float]
    calls: Sequence[tuple[Operation, tuple[int, ...], int]]
    outputs: Sequence[tuple[int, tuple[int, int]]]

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
                calls.append((_operation(number), tuple(present[place] for place in reads), value))
            present[writes[0]] = value
        return cls(given=given, constants=constants, calls=calls, outputs=outputs)

    def steps(
        self, arguments: Sequence[Array], results: Sequence[Array], count: int
    ) -> list[tuple[Operation, tuple[Array, ...]]]:
        """Return operations with the arrays that each reads and, last, writes."""
        values = {value: arguments[i][j] for value, (i, j) in self.given.items()}
        values |= {value: np.array(constant) for value, constant in self.constants.items()}
        left = [(value, results[i][j]) for value, (i, j) in self.outputs]
        at_once = {value: place for value, place in reversed(left) if value not in values}
        last = {value: k for k, (_, reads, _) in enumerate(self.calls) for value in reads}
        free: list[Array] = []
        steps: list[tuple[Operation, tuple[Array, ...]]] = []
        for k, (operation, reads, written) in enumerate(self.calls):
            values[written] = at_once[written] if written in at_once else free.pop() if free else np.empty(count)
            steps.append((operation, (*(values[value] for value in reads), values[written])))
            # What was read for the last time makes room for others; not for this result, which may be written in parts.
            free += [values[value] for value in set(reads) if last[value] == k and self._is_passing(value, at_once)]
        return steps + [(_copy, (values[value], place)) for value, place in left if at_once.get(value) is not place]

    def _is_passing(self, value: int, at_once: Mapping[int, Array]) -> bool:
        return value not in self.given and value not in self.constants and value not in at_once


def _operation(number: int) -> Operation:
    operation = _OPERATIONS.get(number)
    if operation is None:
        got = next((name for name, value in vars(ca).items() if name.startswith("OP_") and value == number), "")
        known = sorted(name for name in vars(ca) if name.startswith("OP_") and getattr(ca, name) in _OPERATIONS)
        raise DesignError("lanes", f"the operation {got}", ", ".join(known))
    return operation


def _copy(a: Array, out: Array) -> None:
    np.copyto(out, a)


def _twice(a: Array, out: Array) -> None:
    np.add(a, a, out)


def _where(condition: Array, a: Array, out: Array) -> None:
    """Write a where the condition is not zero, else 0, even where a is no number."""
    out.fill(0.0)
    np.copyto(out, a, where=condition != 0.0)


_OPERATIONS: Final[Mapping[int, Operation]] = {
    ca.OP_ASSIGN: _copy,
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_DIV: np.divide,
    ca.OP_NEG: np.negative,
    ca.OP_TWICE: _twice,
    ca.OP_SQ: np.square,
    ca.OP_INV: np.reciprocal,
    ca.OP_SQRT: np.sqrt,
    ca.OP_POW: np.power,
    ca.OP_CONSTPOW: np.power,
    ca.OP_EXP: np.exp,
    ca.OP_LOG: np.log,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_TAN: np.tan,
    ca.OP_ASIN: np.arcsin,
    ca.OP_ACOS: np.arccos,
    ca.OP_ATAN: np.arctan,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_SINH: np.sinh,
    ca.OP_COSH: np.cosh,
    ca.OP_TANH: np.tanh,
    ca.OP_FABS: np.fabs,
    ca.OP_SIGN: np.sign,
    ca.OP_FMIN: np.fmin,
    ca.OP_FMAX: np.fmax,
    ca.OP_LT: np.less,
    ca.OP_LE: np.less_equal,
    ca.OP_EQ: np.equal,
    ca.OP_NE: np.not_equal,
    ca.OP_NOT: np.logical_not,
    ca.OP_AND: np.logical_and,
    ca.OP_OR: np.logical_or,
    ca.OP_IF_ELSE_ZERO: _where,
}
