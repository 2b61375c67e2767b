"""Limits of the actuators: least and largest input of every axis, norms and weighted sums of axes, rates of change."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache, reduce
from math import sqrt
from typing import Final

import casadi as ca
import numpy as np

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.arguments.axis_limits import PerAxis, each_of, interval_of, rates_of
from passafe.arguments.ranges import require_positive
from passafe.errors import DesignError, ShapeError
from passafe.interior_point import interior_point
from passafe.numerics.workspace import Array

LEAST_WAY: Final = 1e-300
LARGEST: Final = 1e150
"""Finite stand-in for infinity, whose square is finite too."""

ROUNDING: Final = 1e-12
"""Distance beyond a half-space or norm up to which an input before counts as in it, relative to the reach or bound."""

SWEEPS: Final = 3
"""How often a correction goes through the half-spaces, forth and back."""

INSET: Final = 1e-7
"""Distance from the half-spaces that corrections aim at, relative to the reach."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """The set of inputs that may be sent after u, which is convex.

    {u⁺ : lowᵢ ≤ u⁺ᵢ ≤ highᵢ, ‖u⁺ over some axes‖ ≤ B, wᵀu⁺ ≤ b, −dt·fallᵢ ≤ u⁺ᵢ − uᵢ ≤ dt·riseᵢ}.

    It is never empty while u itself keeps all but the rates. Should u be outside, the rest comes before the rates, and
    corrections lead towards ``centre``. Zero need not be in it.

    Attributes:
        low: Least input of each axis, units of u.
        high: Largest input of each axis, above the least.
        norms: Balls over some axes.
        half_spaces: Half-spaces.
        fall_per_s: Fastest fall of each axis, positive, units of u per second; ``None`` for no limit of the rates.
        rise_per_s: Fastest rise of each axis, positive; ``None`` where ``fall_per_s`` is.
        centre: An input well inside all limits but the rates, units of u: zero where that is in the middle of all axes.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    norms: tuple[NormBound, ...] = ()
    half_spaces: tuple[HalfSpace, ...] = ()
    fall_per_s: tuple[float, ...] | None = None
    rise_per_s: tuple[float, ...] | None = None
    centre: tuple[float, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Refuse sets without an interior.

        Raises:
            ShapeError: A norm or a half-space of other axes.
            DesignError: No input is inside all limits.
        """
        m = len(self.low)
        for norm in self.norms:
            if max(norm.axes) >= m:
                raise ShapeError("input norm axes", list(norm.axes), f"numbers below {m}")
        for half_space in self.half_spaces:
            if len(half_space.weights) != m:
                raise ShapeError("input half-space weights", f"{len(half_space.weights)} numbers", f"{m}")
        centre = interior_point(self.low, self.high, self.norms, self.half_spaces)
        if centre is None:
            raise DesignError("input limits", "a set of inputs without an interior", "limits that some input keeps")
        object.__setattr__(self, "centre", centre)

    @classmethod
    def of(
        cls,
        m: int,
        magnitude: PerAxis | None,
        norm: float | None = None,
        rate_per_s: PerAxis | None = None,
        *,
        low: PerAxis | None = None,
        high: PerAxis | None = None,
        norms: Sequence[NormBound] = (),
        half_spaces: Sequence[HalfSpace] = (),
        rate_low_per_s: PerAxis | None = None,
        rate_high_per_s: PerAxis | None = None,
    ) -> "Limits":
        """Return the limits for m axes; one number counts for each of them.

        Args:
            m: Number of axes.
            magnitude: Largest |uᵢ|, positive; may be ``None`` where ``low`` and ``high`` are given.
            norm: Largest ‖u‖ of all axes, positive.
            rate_per_s: Largest |u̇ᵢ|, positive.
            low: Least uᵢ, in the place of −magnitude.
            high: Largest uᵢ, in the place of the magnitude.
            norms: Balls over some axes.
            half_spaces: Half-spaces.
            rate_low_per_s: Least u̇ᵢ, negative, in the place of −rate_per_s; without both, a fall has no limit.
            rate_high_per_s: Largest u̇ᵢ, positive, likewise.

        Raises:
            ShapeError: Another number of axes.
            DesignError: A limit that is not a positive finite number, or leaves no input.
        """
        balls = each_of("input_norms", norms, NormBound)
        if norm is not None:
            require_positive("input_norm_bound", norm)
            balls = (NormBound(axes=tuple(range(m)), bound=norm), *balls)
        least, most = interval_of(m, magnitude, low, high)
        fall, rise = rates_of(m, rate_per_s, rate_low_per_s, rate_high_per_s)
        return cls(
            low=least,
            high=most,
            norms=balls,
            half_spaces=each_of("input_half_spaces", half_spaces, HalfSpace),
            fall_per_s=fall,
            rise_per_s=rise,
        )

    @property
    def magnitude(self) -> tuple[float, ...]:
        """Largest |uᵢ| of each axis, units of u."""
        return tuple(max(-low, high) for low, high in zip(self.low, self.high, strict=True))

    @property
    def norm(self) -> float | None:
        """Smallest bound of the norm of all axes; ``None`` without one."""
        return min((norm.bound for norm in self.norms if len(norm.axes) == len(self.low)), default=None)

    @property
    def has_only_axes(self) -> bool:
        """True if every axis is limited on its own."""
        return not self.norms and not self.half_spaces

    @property
    def reach(self) -> float:
        """Largest distance between two inputs within the limits of the axes, units of u."""
        return sqrt(sum((high - low) ** 2 for low, high in zip(self.low, self.high, strict=True)))

    def interval(self, u: ca.SX, dt_s: float) -> tuple[ca.SX, ca.SX]:
        """Return the least and the largest u⁺ that axes and rates allow after u, each of shape (m, 1)."""
        least, most = ca.DM(list(self.low)), ca.DM(list(self.high))
        if self.fall_per_s is None or self.rise_per_s is None:
            return ca.SX(least), ca.SX(most)
        fall, rise = dt_s * ca.DM(list(self.fall_per_s)), dt_s * ca.DM(list(self.rise_per_s))
        return ca.fmin(ca.fmax(u - fall, least), most), ca.fmax(ca.fmin(u + rise, most), least)

    def clip(self, u_plus: ca.SX, u: ca.SX | ca.DM, low: ca.SX | ca.DM, high: ca.SX | ca.DM) -> ca.SX:
        """Return an input within the limits near u⁺, shape (m, 1): into the interval axis by axis, then to the rest.

        First onto the half-spaces that it misses, one after the other; what is still outside is led towards u, the
        input before, as far as needed: the limits are convex and hold there, so they hold along the way. Only where u
        itself is outside does the way lead towards the centre.

        Args:
            u_plus: Shape (m, 1).
            u: Input before, shape (m, 1).
            low: Least u⁺, shape (m, 1).
            high: Largest u⁺, shape (m, 1).
        """
        clipped = ca.fmin(ca.fmax(u_plus, low), high)
        if self.has_only_axes:
            return clipped
        for half_space in (*self.half_spaces, *reversed(self.half_spaces)) * SWEEPS:
            w = ca.DM(list(half_space.weights))
            missed = ca.fmax(ca.dot(w, clipped) - half_space.bound + INSET * self.reach, 0)
            beyond = ca.dot(w, clipped) > half_space.bound
            clipped = ca.fmin(ca.fmax(ca.if_else(beyond, clipped - missed * w, clipped), low), high)
        origin = ca.if_else(self._holds(u), u, ca.DM(list(self.centre)))
        way = clipped - origin
        ways = [*(_to_sphere(norm, origin, way, clipped) for norm in self.norms)]
        ways += [_to_plane(half_space, origin, way, clipped) for half_space in self.half_spaces]
        share = reduce(ca.fmin, (share for _, share in ways))
        is_outside = reduce(ca.logic_or, (beyond for beyond, _ in ways))
        return ca.if_else(is_outside, origin + share * way, clipped)

    def nearest(self, u_plus: Array, u: Array, low: Array, high: Array) -> Array:
        """Return ``clip`` of plain numbers; a NaN counts as 0.

        Args:
            u_plus: Any numbers, shape (m,).
            u: Input before, shape (m,); a NaN counts as zero.
            low: Least u⁺, shape (m,).
            high: Largest u⁺, shape (m,).
        """
        given = (ca.DM(np.nan_to_num(each, posinf=LARGEST, neginf=-LARGEST)) for each in (u_plus, u, low, high))
        return np.asarray(_clip_function(self)(*given).full().ravel())

    def excess(self, u: Array, before: Array | None = None, dt_s: float = 0.0) -> Array:
        """Return by how much inputs exceed the limit that they exceed most, shape (…), units of u; ≤ 0 within all.

        A NaN stays one.

        Args:
            u: Inputs, shape (m, …).
            before: Inputs before, for the rates, shape (m, …); without them rates do not count.
            dt_s: Time between them, s.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # infinite and NaN are beyond every limit
            axes = (len(self.low),) + (1,) * (u.ndim - 1)
            found = [np.reshape(self.low, axes) - u, u - np.reshape(self.high, axes)]
            if before is not None and self.fall_per_s is not None and self.rise_per_s is not None:
                step = u - before
                found += [
                    -step - dt_s * np.reshape(self.fall_per_s, axes),
                    step - dt_s * np.reshape(self.rise_per_s, axes),
                ]
            largest: Array = np.max(np.maximum.reduce(found), axis=0)
            for norm in self.norms:
                part = u[list(norm.axes)]
                length = np.sqrt((part * part).sum(axis=0))
                largest = np.maximum(largest, length - norm.bound)
            for half_space in self.half_spaces:
                largest = np.maximum(largest, np.tensordot(half_space.weights, u, axes=1) - half_space.bound)
            return largest

    def _holds(self, u: ca.SX | ca.DM) -> ca.SX:
        """Return whether an input keeps all limits but the rates up to rounding, scalar; false for a NaN."""
        held = [ca.mmin(ca.vertcat(u - ca.DM(list(self.low)), ca.DM(list(self.high)) - u)) >= 0]
        held += [ca.sumsqr(u[list(norm.axes)]) <= (1 + ROUNDING) * norm.bound**2 for norm in self.norms]
        for half_space in self.half_spaces:
            held.append(ca.dot(ca.DM(list(half_space.weights)), u) <= half_space.bound + ROUNDING * self.reach)
        return reduce(ca.logic_and, held)


@lru_cache(maxsize=64)
def _clip_function(limits: Limits) -> ca.Function:
    symbols = [ca.SX.sym(name, len(limits.low)) for name in ("u_plus", "u", "low", "high")]
    return ca.Function("clip", symbols, [limits.clip(*symbols)])


def _to_sphere(norm: NormBound, origin: ca.SX, way: ca.SX, end: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return whether the way's end is beyond the sphere, and the share of the way up to there, or 1."""
    axes = list(norm.axes)
    start, step = origin[axes], way[axes]
    is_beyond = ca.sumsqr(end[axes]) > norm.bound**2
    a, b, c = ca.sumsqr(step), ca.dot(start, step), ca.sumsqr(start) - norm.bound**2
    share = (ca.sqrt(ca.fmax(b * b - a * c, 0)) - b) / ca.fmax(a, LEAST_WAY)
    return is_beyond, ca.if_else(is_beyond, ca.fmax(share, 0), 1)


def _to_plane(half_space: HalfSpace, origin: ca.SX, way: ca.SX, end: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return whether the way's end is beyond the plane, and the share of the way up to there, or 1."""
    w = ca.DM(list(half_space.weights))
    is_beyond = ca.dot(w, end) > half_space.bound
    share = ca.fmax(half_space.bound - ca.dot(w, origin), 0) / ca.fmax(ca.dot(w, way), LEAST_WAY)
    return is_beyond, ca.if_else(is_beyond, ca.fmin(share, 1), 1)
