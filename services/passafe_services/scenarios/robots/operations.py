"""Operations that a robot's functions may be made of, by name: elementary ones, nothing that calls or loads code."""

from collections.abc import Mapping
from typing import Final

import casadi as ca

_BINARY: Final = (
    "add sub mul div pow constpow fmin fmax atan2 hypot fmod remainder copysign lt le eq ne and or if_else_zero"
)
_UNARY: Final = (
    "neg exp log log1p expm1 sqrt sq twice inv sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf erfinv "
    "fabs sign floor ceil not"
)

NUMBERS: Final[Mapping[str, int]] = {
    name: getattr(ca, f"OP_{name.upper()}") for name in (*_BINARY.split(), *_UNARY.split())
}
"""CasADi's number of each operation; names, unlike numbers, stay the same from version to version."""

ARITY: Final[Mapping[str, int]] = dict.fromkeys(_BINARY.split(), 2) | dict.fromkeys(_UNARY.split(), 1)
"""Number of arguments of each operation."""

NAMES: Final[Mapping[int, str]] = {number: name for name, number in NUMBERS.items()}


def applied(name: str, arguments: list[ca.SX]) -> ca.SX:
    """Return an operation of one or two scalars."""
    apply = ca.SX.unary if len(arguments) == 1 else ca.SX.binary
    return apply(NUMBERS[name], *arguments)
