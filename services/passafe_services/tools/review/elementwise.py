"""A CasADi function of a few numbers, evaluated at many at once: each of its operations once, over all columns."""

from collections.abc import Callable, Sequence
from typing import Final

import casadi as ca
import numpy as np

from passafe_services.tools.review.plant_evaluator import FloatArray

_UNARY: Final[dict[int, Callable[[FloatArray], FloatArray]]] = {
    ca.OP_ASSIGN: np.positive,
    ca.OP_NEG: np.negative,
    ca.OP_EXP: np.exp,
    ca.OP_LOG: np.log,
    ca.OP_SQRT: np.sqrt,
    ca.OP_SQ: np.square,
    ca.OP_TWICE: lambda a: a + a,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_TAN: np.tan,
    ca.OP_ASIN: np.arcsin,
    ca.OP_ACOS: np.arccos,
    ca.OP_ATAN: np.arctan,
    ca.OP_NOT: lambda a: np.where(a == 0, 1.0, 0.0),
    ca.OP_FLOOR: np.floor,
    ca.OP_CEIL: np.ceil,
    ca.OP_FABS: np.fabs,
    ca.OP_SIGN: np.sign,
    ca.OP_INV: np.reciprocal,
    ca.OP_SINH: np.sinh,
    ca.OP_COSH: np.cosh,
    ca.OP_TANH: np.tanh,
    ca.OP_LOG1P: np.log1p,
    ca.OP_EXPM1: np.expm1,
}

_BINARY: Final[dict[int, Callable[[FloatArray, FloatArray], FloatArray]]] = {
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_DIV: np.divide,
    ca.OP_POW: np.power,
    ca.OP_CONSTPOW: np.power,
    ca.OP_LT: lambda a, b: np.where(a < b, 1.0, 0.0),
    ca.OP_LE: lambda a, b: np.where(a <= b, 1.0, 0.0),
    ca.OP_EQ: lambda a, b: np.where(a == b, 1.0, 0.0),
    ca.OP_NE: lambda a, b: np.where(a != b, 1.0, 0.0),
    ca.OP_AND: lambda a, b: np.where((a != 0) & (b != 0), 1.0, 0.0),
    ca.OP_OR: lambda a, b: np.where((a != 0) | (b != 0), 1.0, 0.0),
    ca.OP_FMIN: np.fmin,
    ca.OP_FMAX: np.fmax,
    ca.OP_COPYSIGN: np.copysign,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_HYPOT: np.hypot,
    ca.OP_IF_ELSE_ZERO: lambda a, b: np.where(a != 0, b, 0.0),
}

_Step = Callable[[list[FloatArray], Sequence[FloatArray], list[FloatArray]], None]
"""Does one operation: reads and writes the registers, reads the arguments, writes the results."""


class Elementwise:
    """A function with dense arguments and one dense result column, for N columns at once.

    CasADi's own map walks through the operations once a column; numpy does each on all columns, twenty times as fast
    for thousands of them. A function with an operation that is not known here is left to CasADi.

    Attributes:
        function: What is evaluated.
    """

    def __init__(self, name: str, arguments: Sequence[ca.SX], result: ca.SX) -> None:
        """Compile.

        Args:
            name: Of the function.
            arguments: Column vectors of symbols.
            result: Column vector of expressions of them.
        """
        self.function = ca.Function(name, list(arguments), [ca.densify(result)], {"cse": True})
        self._rows = result.numel()
        self._steps = _steps_of(self.function)

    def __call__(self, *arguments: FloatArray) -> FloatArray:
        """Return the results, shape (rows, N), for arguments of shape (rows of each, N)."""
        if self._steps is None:
            return np.asarray(self.function(*arguments).full(), dtype=np.float64)
        columns = arguments[0].shape[1]
        registers = [np.zeros(0)] * int(self.function.sz_w())
        results = [np.zeros(columns)] * self._rows
        # As CasADi does: what is no number is a result like others.
        with np.errstate(all="ignore"):
            for step in self._steps:
                step(registers, arguments, results)
        return np.array([np.broadcast_to(row, columns) for row in results]).reshape(self._rows, columns)


def _steps_of(function: ca.Function) -> list[_Step] | None:
    steps = [_step_of(function, k) for k in range(function.n_instructions())]
    known = [step for step in steps if step is not None]
    return known if len(known) == len(steps) else None


def _step_of(function: ca.Function, k: int) -> _Step | None:
    operation = function.instruction_id(k)
    read, written = function.instruction_input(k), function.instruction_output(k)
    if operation == ca.OP_CONST:
        return _constant(function.instruction_constant(k), written[0])
    if operation == ca.OP_INPUT:
        return _argument(read[0], read[1], written[0])
    if operation == ca.OP_OUTPUT:
        return _result(read[0], written[1])
    if operation in _UNARY:
        return _unary(_UNARY[operation], read[0], written[0])
    if operation in _BINARY:
        return _binary(_BINARY[operation], read[0], read[1], written[0])
    return None


def _constant(value: float, to: int) -> _Step:
    constant = np.array(value, dtype=np.float64)

    def step(registers: list[FloatArray], _: Sequence[FloatArray], __: list[FloatArray]) -> None:
        registers[to] = constant

    return step


def _argument(which: int, row: int, to: int) -> _Step:
    def step(registers: list[FloatArray], arguments: Sequence[FloatArray], _: list[FloatArray]) -> None:
        registers[to] = arguments[which][row]

    return step


def _result(read: int, row: int) -> _Step:
    def step(registers: list[FloatArray], _: Sequence[FloatArray], results: list[FloatArray]) -> None:
        results[row] = registers[read]

    return step


def _unary(operation: Callable[[FloatArray], FloatArray], a: int, to: int) -> _Step:
    def step(registers: list[FloatArray], _: Sequence[FloatArray], __: list[FloatArray]) -> None:
        registers[to] = operation(registers[a])

    return step


def _binary(operation: Callable[[FloatArray, FloatArray], FloatArray], a: int, b: int, to: int) -> _Step:
    def step(registers: list[FloatArray], _: Sequence[FloatArray], __: list[FloatArray]) -> None:
        registers[to] = operation(registers[a], registers[b])

    return step
