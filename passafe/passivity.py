"""Passivity as a constraint on the input: storage functions and the power margin (paper, section 3.2)."""

from dataclasses import dataclass

import casadi as ca

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described
from passafe.arguments.ranges import require_positive
from passafe.class_k import ClassK, Linear, class_k_function
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.errors import DesignError
from passafe.system import System
from passafe.tank import Tank


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Passivity:
    """Demand of the filter on the energy.

    The row is soft: ``h_u ≥ −δ`` without a tank, ``h_u ≥ −κ(E − E_r) − δ`` with one, at the price
    ½·slack_weight·δ² beside ½‖u⁺ − u_ref‖². The continuous law of the paper has it hard.

    Attributes:
        V: Storage function, scalar expression of x, J; a number stands for a constant.
        class_k: γ_u of the continuous law; a number stands for a linear one with that gain.
        slack_weight: ρ_u, price of the slack, (units of u)²/W².
        tank: Tank that may be drawn on; without one every instant must be passive.
        relaxed_above: Slack from which a decision counts as relaxed, W.
        derivative_bounds: Bounds of the first two time derivatives of the power margin, where they are too long to be
            enclosed; if they are not given, they are enclosed.
    """

    V: ca.SX
    class_k: ClassK = Linear(gain=100.0)  # noqa: RUF009 - ClassK is frozen
    slack_weight: float = 1e6
    tank: Tank | None = None
    relaxed_above: float = 1e-3
    derivative_bounds: DerivativeBounds | None = None

    def __post_init__(self) -> None:
        """Refuse weights that make the quadratic program meaningless."""
        object.__setattr__(self, "V", as_column("storage V", self.V))
        object.__setattr__(self, "class_k", class_k_function("passivity class_k", self.class_k))
        if not isinstance(self.tank, Tank | None):
            raise DesignError("passivity tank", described(self.tank), "a Tank, or None")
        require_positive("passivity slack_weight", self.slack_weight)
        require_positive("passivity relaxed_above", self.relaxed_above)

    @property
    def initial_j(self) -> float:
        """Energy in the tank at the start, J; zero without one."""
        return 0.0 if self.tank is None else self.tank.initial_j


def power_margin(system: System, V: ca.SX) -> ca.SX:
    """Return h_u(x, u) = g(x)ᵀu − L_f V(x, u), W: what the plant dissipates (paper, equation 10).

    gᵀu is the power through the system's port, ``System.power``.

    The plant is passive with storage V along a trajectory on which h_u ≥ 0 (paper, lemma 1).

    Args:
        system: The plant.
        V: Storage function, scalar expression of x, J.

    Raises:
        ShapeError: V is no scalar.
    """
    system.require_state_function("storage V", V, 1)
    return system.power - system.lie_derivative(V)
