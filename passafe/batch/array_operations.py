"""CasADi's scalar operations as NumPy's, which do each for many numbers at once."""

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array

Operation: TypeAlias = Callable[..., object]
"""Reads one or two arrays and writes the last one."""


def _copy(a: Array, out: Array) -> None:
    np.copyto(out, a)


def _twice(a: Array, out: Array) -> None:
    np.add(a, a, out)


def _where(condition: Array, a: Array, out: Array) -> None:
    """Write a where the condition is not zero, else 0, even where a is no number."""
    out.fill(0.0)
    np.copyto(out, a, where=condition != 0.0)


OPERATIONS: Final[Mapping[int, Operation]] = {
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
    ca.OP_EXPM1: np.expm1,
    ca.OP_LOG: np.log,
    ca.OP_LOG1P: np.log1p,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_TAN: np.tan,
    ca.OP_ASIN: np.arcsin,
    ca.OP_ACOS: np.arccos,
    ca.OP_ATAN: np.arctan,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_HYPOT: np.hypot,
    ca.OP_SINH: np.sinh,
    ca.OP_COSH: np.cosh,
    ca.OP_TANH: np.tanh,
    ca.OP_FABS: np.fabs,
    ca.OP_SIGN: np.sign,
    ca.OP_COPYSIGN: np.copysign,
    ca.OP_FLOOR: np.floor,
    ca.OP_CEIL: np.ceil,
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
"""By CasADi's number of the operation."""


def known_operations() -> list[str]:
    """Return the names of the operations that arrays know, sorted."""
    return sorted(name for name in vars(ca) if name.startswith("OP_") and getattr(ca, name) in OPERATIONS)


def unknown_operation(function: ca.Function) -> str:
    """Return the name of the first operation that arrays do not know; empty if they know all."""
    known = {ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST, *OPERATIONS}
    for k in range(function.n_instructions()):
        number = function.instruction_id(k)
        if number not in known:
            return next(name for name, value in vars(ca).items() if name.startswith("OP_") and value == number)
    return ""
