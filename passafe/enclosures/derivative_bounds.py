"""Bounds of the time derivatives of a function in closed form, for functions that are too long to be enclosed."""

from dataclasses import dataclass

import casadi as ca

from passafe.enclosures.reachable_tube import Tube
from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DerivativeBounds:
    """Bounds of |ḣ|, |ḧ|, … along every motion of the plant while an input is held.

    An enclosure of the derivatives of a formula is many times as long as the formula: that of the place of an arm's tip
    has some hundred operations, its derivatives with their enclosures have tens of thousands. Where the motion has a
    bound of its own, as a product of rotations has by the rates of its angles, that bound takes their place.

    Attributes:
        x_size: Symbol for the largest |x| of each state meanwhile, shape (n, 1).
        u_size: Symbol for the largest |u| of each axis, shape (m, 1).
        held_s: Symbol for how long the input is held at most, s.
        orders: Bounds of the first k derivatives, expressions of the plant's x at the beginning and of these three
            symbols, in each of which they do not fall; shape (k, 1).
    """

    x_size: ca.SX
    u_size: ca.SX
    held_s: ca.SX
    orders: ca.SX

    def within(self, system: System, tube: Tube, held_s: float, input_radius: ca.SX) -> ca.SX:
        """Return the bounds for all motions in a tube, expressions of x and u, shape (k, 1).

        Args:
            system: The plant.
            tube: Around x, for the same inputs.
            held_s: T, how long the input is held at most, s.
            input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).
        """
        sizes = [ca.fabs(system.x) + tube.radius, ca.fabs(system.u) + input_radius, ca.SX(held_s)]
        (bounds,) = ca.substitute([self.orders], [self.x_size, self.u_size, self.held_s], sizes)
        return bounds
