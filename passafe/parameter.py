"""A physical parameter of a system: a named symbol in its dynamics, and the value that the model takes for it."""

from dataclasses import dataclass

import casadi as ca

from passafe.arguments.numbers import described
from passafe.arguments.ranges import require_finite
from passafe.errors import DesignError


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Parameter:
    """A constant of the dynamics that a robot may turn out to have otherwise.

    Attributes:
        name: Its name in sets, scenarios and logs, for example ``mass``.
        symbol: What stands for it in the system's expressions, a scalar symbol.
        value: Nominal value, in the parameter's own unit.
    """

    name: str
    symbol: ca.SX
    value: float

    def __post_init__(self) -> None:
        """Refuse what is no symbol, and values that are not finite."""
        if not isinstance(self.name, str) or not self.name:
            raise DesignError("parameter name", described(self.name), "a non-empty string")
        part, symbol = f"parameter {self.name!r}", self.symbol
        if not isinstance(symbol, ca.SX) or not symbol.is_scalar() or not symbol.is_symbolic():
            raise DesignError(f"{part} symbol", described(symbol), "one casadi.SX symbol")
        require_finite(f"{part} value", self.value, "in the parameter's unit")
        object.__setattr__(self, "value", float(self.value))

    @classmethod
    def of(cls, name: str, value: float) -> "Parameter":
        """Return a parameter with a symbol of its own, which has the same name."""
        return cls(name=name, symbol=ca.SX.sym(name if isinstance(name, str) else ""), value=value)
