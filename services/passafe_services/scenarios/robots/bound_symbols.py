"""Symbols in which a carried robot's bounds of derivatives are written."""

from typing import NamedTuple, Self

import casadi as ca

from passafe.enclosures.derivative_bounds import DerivativeBounds


class BoundSymbols(NamedTuple):
    """Symbols of all bounds of one robot."""

    x_size: ca.SX
    u_size: ca.SX
    held_s: ca.SX

    @classmethod
    def of(cls, n: int, m: int) -> Self:
        """Return symbols for n states and m inputs."""
        return cls(ca.SX.sym("x_size", n), ca.SX.sym("u_size", m), ca.SX.sym("held_s"))

    @property
    def symbols(self) -> dict[str, ca.SX]:
        """Return them by name."""
        return self._asdict()

    def orders(self, bounds: DerivativeBounds) -> ca.SX:
        """Return bounds, written in other symbols, in these."""
        orders: ca.SX = ca.substitute([bounds.orders], [bounds.x_size, bounds.u_size, bounds.held_s], list(self))[0]
        return orders

    def bounds(self, orders: ca.SX) -> DerivativeBounds:
        """Return bounds in these symbols."""
        return DerivativeBounds(x_size=self.x_size, u_size=self.u_size, held_s=self.held_s, orders=orders)
