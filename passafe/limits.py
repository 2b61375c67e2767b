"""Limits of the actuators: magnitude of every axis, norm of the whole input, and rate of change."""

from dataclasses import dataclass
from math import sqrt
from typing import Final

import casadi as ca
import numpy as np

from passafe.arguments import is_one_number, numbers
from passafe.errors import ShapeError
from passafe.ranges import require_positive
from passafe.workspace import Array

LEAST_WAY: Final = 1e-300
LARGEST: Final = 1e150
"""Finite stand-in for infinity, whose square is finite too."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """The set of inputs that may be sent: {u⁺ : |u⁺ᵢ| ≤ bᵢ, ‖u⁺‖ ≤ B, |u⁺ᵢ − uᵢ| ≤ dt·rᵢ}, u the input before.

    It is never empty while u itself is in it. Should u lie outside the magnitudes, they come before the rates.

    Attributes:
        magnitude: b, one for each axis, units of u.
        norm: B, units of u; ``None`` for no limit of its own.
        rate_per_s: r, one for each axis, units of u per second; ``None`` for no limit.
    """

    magnitude: tuple[float, ...]
    norm: float | None = None
    rate_per_s: tuple[float, ...] | None = None

    @classmethod
    def of(
        cls,
        m: int,
        magnitude: float | tuple[float, ...],
        norm: float | None,
        rate_per_s: float | tuple[float, ...] | None,
    ) -> "Limits":
        """Return the limits for m axes; one number counts for each of them.

        Raises:
            ShapeError: Another number of axes.
            DesignError: A limit that is not a positive finite number.
        """
        if norm is not None:
            require_positive("input_norm_bound", norm)
        rates = None if rate_per_s is None else _each_axis("input_rate_bound_per_s", rate_per_s, m)
        return cls(magnitude=_each_axis("input_bound", magnitude, m), norm=norm, rate_per_s=rates)

    @property
    def reach(self) -> float:
        """Largest distance between two inputs within the magnitudes, whatever their norm, units of u."""
        return 2 * sqrt(sum(b * b for b in self.magnitude))

    def interval(self, u: ca.SX, dt_s: float) -> tuple[ca.SX, ca.SX]:
        """Return the least and the largest u⁺ that magnitude and rate allow after u, each of shape (m, 1)."""
        b = ca.DM(list(self.magnitude))
        if self.rate_per_s is None:
            return ca.SX(-b), ca.SX(b)
        step = dt_s * ca.DM(list(self.rate_per_s))
        return ca.fmin(ca.fmax(u - step, -b), b), ca.fmax(ca.fmin(u + step, b), -b)

    def clip(self, u_plus: ca.SX, u: ca.SX | ca.DM, low: ca.SX | ca.DM, high: ca.SX | ca.DM) -> ca.SX:
        """Return an input within the limits near u⁺, shape (m, 1): into the interval axis by axis, then to the norm.

        The correction leads towards u, the input before, as far as needed: both limits are convex and hold there, so
        they hold along it. Only where u itself is too long does it lead towards zero.

        Args:
            u_plus: Shape (m, 1).
            u: Input before, shape (m, 1).
            low: Least u⁺, shape (m, 1).
            high: Largest u⁺, shape (m, 1).
        """
        clipped = ca.fmin(ca.fmax(u_plus, low), high)
        if self.norm is None:
            return clipped
        too_long = ca.sumsqr(clipped) > self.norm**2
        origin = ca.if_else(ca.sumsqr(u) > self.norm**2, 0, u)
        way = clipped - origin
        a, b, c = ca.sumsqr(way), ca.dot(origin, way), ca.sumsqr(origin) - self.norm**2
        share = (ca.sqrt(ca.fmax(b * b - a * c, 0)) - b) / ca.fmax(a, LEAST_WAY)
        return ca.if_else(too_long, origin + share * way, clipped)

    def nearest(self, u_plus: Array, u: Array, low: Array, high: Array) -> Array:
        """Return ``clip`` of plain numbers; a NaN counts as 0.

        Args:
            u_plus: Any numbers, shape (m,).
            u: Input before, shape (m,); a NaN counts as zero.
            low: Least u⁺, shape (m,).
            high: Largest u⁺, shape (m,).
        """
        numbers = (ca.DM(np.nan_to_num(each, posinf=LARGEST, neginf=-LARGEST)) for each in (u_plus, u, low, high))
        symbols = [ca.SX.sym(name, len(u)) for name in ("u_plus", "u", "low", "high")]
        return np.asarray(ca.Function("clip", symbols, [self.clip(*symbols)])(*numbers).full().ravel())


def _each_axis(field: str, value: float | tuple[float, ...], m: int) -> tuple[float, ...]:
    given = numbers(field, value)
    each = given * m if is_one_number(value) else given
    if len(each) != m:
        raise ShapeError(field, f"{len(each)} numbers", f"one number, or {m}: one for each axis")
    for one in each:
        require_positive(field, one)
    return each
