"""The controlled system ẋ = f(x, u), y = g(x), given as symbolic expressions."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import casadi as ca

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described, members
from passafe.errors import DesignError, ShapeError
from passafe.parameter import Parameter


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class System:
    """A plant ẋ = f(x, u), y = g(x) with a port through which it is driven (paper, equation 1).

    A port is a pair of as many outputs as inputs, whose product is the power that is supplied: yᵀu, unless ``port_y``
    and ``port_u`` say which. Each part may also be given as a sequence of scalars, which makes a column.

    Attributes:
        x: State symbol, shape (n, 1).
        u: Input symbol, shape (m, 1).
        f: ẋ as an expression of x and u, shape (n, 1), state units per second. It may be given with the parameters'
            symbols in it; here they have their values.
        y: Output g(x), a column of m rows; of any number where a port is given.
        t: Time symbol, s: safe sets may move, the plant itself does not change with time.
        port_y: The port's output, expression of x, shape (k, 1); y if not given.
        port_u: The port's input, expression of u, shape (k, 1); u if not given.
        parameters: Constants of f, y and port that a robot may turn out to have otherwise.
        general_f: f with the parameters' symbols in it.
        n: Number of states.
        m: Number of inputs.
    """

    x: ca.SX
    u: ca.SX
    f: ca.SX
    y: ca.SX
    t: ca.SX = field(default_factory=lambda: ca.SX.sym("t"))
    port_y: ca.SX = field(default_factory=lambda: ca.SX(0, 0))
    port_u: ca.SX = field(default_factory=lambda: ca.SX(0, 0))
    parameters: tuple[Parameter, ...] = ()
    general_f: ca.SX = field(init=False)
    n: int = field(init=False)
    m: int = field(init=False)
    _general: tuple[tuple[str, ca.SX], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Refuse shapes that do not fit and expressions with other symbols."""
        for part in ("x", "u", "f", "y", "t", "port_y", "port_u"):
            object.__setattr__(self, part, as_column(f"system {part}", getattr(self, part)))
        for part in ("x", "u"):
            symbol = getattr(self, part)
            if not symbol.is_valid_input() or not symbol.is_column() or symbol.numel() == 0:
                raise ShapeError(f"system {part}", described(symbol), "a non-empty column of symbols")
        if not self.t.is_scalar() or not self.t.is_symbolic():
            raise ShapeError("system t", described(self.t), "one symbol")
        object.__setattr__(self, "n", int(self.x.numel()))
        object.__setattr__(self, "m", int(self.u.numel()))
        self._take_parameters()
        self._require("f", self.f, self.n, symbols=ca.vertcat(self.x, self.u))
        self._take_port()

    def _take_parameters(self) -> None:
        """Put the parameters' values in the place of their symbols."""
        found = members(self.parameters)
        if found is None:
            raise DesignError("system parameters", described(self.parameters), "a sequence of Parameter")
        object.__setattr__(self, "parameters", found)
        for parameter in self.parameters:
            if not isinstance(parameter, Parameter):
                raise DesignError("system parameters", described(parameter), "a sequence of Parameter")
        names = [parameter.name for parameter in self.parameters]
        if len(set(names)) != len(names):
            raise DesignError("system parameters", f"the names {names}", "each name once")
        object.__setattr__(self, "general_f", self.f)
        given = tuple((part, getattr(self, part)) for part in ("f", "y", "port_y", "port_u"))
        object.__setattr__(self, "_general", given)
        for part, expression in given if self.parameters else ():
            object.__setattr__(self, part, self.at_nominal(expression))

    @property
    def general(self) -> Mapping[str, ca.SX]:
        """Return f, y, port_y and port_u by name as they were given, with the parameters' symbols in them."""
        return dict(self._general)

    def at_nominal(self, expression: ca.SX) -> ca.SX:
        """Return an expression with the parameters' values in the place of their symbols, same shape."""
        symbols = [parameter.symbol for parameter in self.parameters]
        values = [ca.SX(parameter.value) for parameter in self.parameters]
        nominal: ca.SX = ca.substitute([expression], symbols, values)[0]
        return nominal

    def with_parameters(self, values: Mapping[str, float]) -> "System":
        """Return another member of the family: the same symbols and expressions, with other values of parameters.

        Args:
            values: New values by name; parameters that are not named keep theirs.

        Raises:
            DesignError: The system has no parameter of such a name.
        """
        known = [parameter.name for parameter in self.parameters]
        unknown = sorted(set(values) - set(known))
        if unknown:
            raise DesignError("system parameters", f"the names {unknown}", f"names among {known}")
        others = tuple(replace(each, value=values.get(each.name, each.value)) for each in self.parameters)
        general = self.general
        return replace(
            self,
            f=general["f"],
            y=general["y"],
            port_y=general["port_y"],
            port_u=general["port_u"],
            parameters=others,
        )

    def _take_port(self) -> None:
        is_given = {part: getattr(self, part).shape != (0, 0) for part in ("port_y", "port_u")}
        rows = max(int(self.y.numel()), 1) if any(is_given.values()) else self.m
        self._require("y", self.y, rows, symbols=self.x)
        for part, instead in (("port_y", self.y), ("port_u", self.u)):
            object.__setattr__(self, part, getattr(self, part) if is_given[part] else instead)
        rows = int(self.port_u.numel())
        self._require("port_u", self.port_u, max(rows, 1), symbols=self.u)
        self._require("port_y", self.port_y, rows, symbols=self.x)

    @property
    def power(self) -> ca.SX:
        """Return the power that the input supplies through the port, expression of x and u, W."""
        return ca.dot(self.port_y, self.port_u)

    def require_state_function(self, part: str, expression: ca.SX, rows: int, *, may_move: bool = False) -> None:
        """Refuse an expression that is no column of ``rows`` functions of x alone, or of x and t if it ``may_move``.

        Raises:
            ShapeError: It has another shape.
            DesignError: It contains other symbols.
        """
        self._require(part, expression, rows, symbols=ca.vertcat(self.x, self.t) if may_move else self.x)

    def lie_derivative(self, expression: ca.SX) -> ca.SX:
        """Return L_f of an expression of x: (∂expression/∂x) f(x, u), same shape."""
        return ca.jtimes(expression, self.x, self.f)

    def rate(self, expression: ca.SX) -> ca.SX:
        """Return the time derivative of an expression of x and t along the plant: L_f + ∂/∂t, same shape."""
        return self.lie_derivative(expression) + ca.jacobian(expression, self.t)

    def general_rate(self, expression: ca.SX) -> ca.SX:
        """Return ``rate`` along the dynamics with the parameters' symbols in them, same shape."""
        return ca.jtimes(expression, self.x, self.general_f) + ca.jacobian(expression, self.t)

    def _require(self, part: str, expression: ca.SX, rows: int, *, symbols: ca.SX) -> None:
        expression = as_column(f"system {part}", expression)
        if expression.shape != (rows, 1):
            raise ShapeError(f"system {part}", f"shape {expression.shape}", f"shape {(rows, 1)}")
        # By identity: another system's symbols may well have the same names.
        known = {symbol.element_hash(): str(symbol) for symbol in ca.vertsplit(symbols)}
        foreign = sorted(str(symbol) for symbol in ca.symvar(expression) if symbol.element_hash() not in known)
        if foreign:
            named = sorted(set(foreign) & {parameter.name for parameter in self.parameters})
            instead = f"; of {', '.join(map(repr, named))} take the parameter's value" if named else ""
            allowed = f"expressions of {sorted(known.values())}{instead}"
            raise DesignError(f"system {part}", f"the symbols {foreign}", allowed)
