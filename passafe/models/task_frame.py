"""Frame in which an operator commands a robot, and the map from there to the plant's input."""

from dataclasses import dataclass

import casadi as ca

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described
from passafe.errors import ShapeError
from passafe.models.robot_parts import texts
from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class TaskFrame:
    """A map u_h = T(x, w) from a command w in a frame of its own, such as the tip of an arm or the body of a car.

    Attributes:
        command: Symbol w, shape (k, 1).
        u_h: T, expression of x and w, shape (m, 1), units of u.
        axes: Name of each coordinate of w, k words; numbered if not given.
    """

    command: ca.SX
    u_h: ca.SX
    axes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a command that is no symbol, and names that do not fit."""
        object.__setattr__(self, "u_h", as_column("task u_h", self.u_h))
        command = self.command
        is_symbol = isinstance(command, ca.SX) and command.is_valid_input() and command.is_column() and command.numel()
        if not is_symbol:
            raise ShapeError("task command", described(command), "a non-empty column of symbols")
        object.__setattr__(self, "axes", texts("task axes", self.axes, int(command.numel())))

    @property
    def size(self) -> int:
        """Return k, the number of coordinates of a command."""
        return int(self.command.numel())

    def rate(self, system: System, command_rate: ca.SX) -> ca.SX:
        """Return u̇_h = (∂T/∂x) f(x, u) + (∂T/∂w) ẇ, shape (m, 1).

        Args:
            system: The plant.
            command_rate: ẇ, shape (k, 1).
        """
        return system.lie_derivative(self.u_h) + ca.jtimes(self.u_h, self.command, command_rate)
