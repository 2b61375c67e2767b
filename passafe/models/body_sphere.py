"""Spheres that cover a robot's body: the parts of it that keep clear of places and of one another."""

from dataclasses import dataclass

import casadi as ca

from passafe.enclosures.derivative_bounds import DerivativeBounds


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BodySphere:
    """A ball that moves with one link.

    Attributes:
        name: Its name.
        centre: Expression of x, m, shape (3, 1).
        radius_m: Radius, m.
        bounds: Bounds of the lengths of the centre's time derivatives.
    """

    name: str
    centre: ca.SX
    radius_m: float
    bounds: DerivativeBounds
