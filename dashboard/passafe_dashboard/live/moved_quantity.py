"""Quantity that a barrier is about, and derivatives of h along it: a position or velocity may be any function of x."""

from dataclasses import dataclass
from typing import Final, Self

import casadi as ca
import numpy as np

from passafe.models.robot import Robot

POSITION: Final = "position"
VELOCITY: Final = "velocity"

_MOST_ROWS: Final = 6
"""Rows of a position that is no part of the state, up to which its motion is solved for."""

_PROBES: Final = 5
_ROUNDING: Final = 1e-6
_DAMPING: Final = 1e-12
"""Added to JJᵀ, which is singular where the state cannot move q in every direction, as a car at rest."""

Derivatives = tuple[ca.SX, ca.SX, ca.SX]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class MovedQuantity:
    """A position or velocity q(x) of a robot, of which h is a function: h = g(q).

    Attributes:
        name: ``position`` or ``velocity``.
        slope: ∂g/∂q, expression of x, shape (k, 1).
        bend: ∂²g/∂q², shape (k, k).
        reached: Projection on the directions in which the state moves q at all, shape (k, k).
        used: Numbers of the coordinates of q that g depends on.
    """

    name: str
    slope: ca.SX
    bend: ca.SX
    reached: ca.SX
    used: tuple[int, ...]

    @classmethod
    def of(cls, robot: Robot, h: ca.SX) -> Self | None:
        """Return the quantity that h is about; ``None`` if that is neither position nor velocity alone."""
        for name, quantity in ((POSITION, robot.position), (VELOCITY, robot.velocity)):
            if not quantity.numel():
                continue
            rows = ca.vertsplit(quantity)
            if all(row.is_symbolic() for row in rows):
                found = _along_states(robot, h, quantity)
            elif len(rows) <= _MOST_ROWS:
                found = _along_motion(robot, h, quantity)
            else:
                found = None
            if found is not None:
                slope, bend, reached = found
                used = tuple(k for k in range(len(rows)) if not slope[k].is_zero())
                return cls(name=name, slope=slope, bend=bend, reached=reached, used=used)
        return None

    def first_point(self, points: int) -> int:
        """Return the number of the first point, of so many, that g depends on, from 0."""
        among = [k // 2 for k in self.used if k < 2 * points]
        return min(among, default=0)


def _along_states(robot: Robot, h: ca.SX, quantity: ca.SX) -> Derivatives | None:
    """Return slope and bend where the quantity's coordinates are states."""
    others = [state for state in ca.vertsplit(robot.system.x) if not ca.depends_on(quantity, state)]
    if any(ca.depends_on(h, state) for state in others):
        return None
    bend, slope = ca.hessian(h, quantity)
    return ca.densify(slope), ca.densify(bend), ca.SX.eye(quantity.numel())


def _along_motion(robot: Robot, h: ca.SX, quantity: ca.SX) -> Derivatives | None:
    """Return slope and bend along the least motion of the state that moves the quantity as wanted.

    With J = ∂q/∂x and J⁺ its right inverse, ∂h/∂x = (∂g/∂q)J gives ∂g/∂q = ∂h/∂x J⁺, if h is a function of q at all.
    Along x + J⁺d, h'' = dᵀ(∂²g/∂q²)d + (∂g/∂q)q'', which is solved for the first term.
    """
    x = robot.system.x
    jacobian = ca.densify(ca.jacobian(quantity, x))
    square = jacobian @ jacobian.T
    inverse = ca.solve(square + _DAMPING * ca.SX.eye(square.shape[0]), jacobian).T
    bend_x, slope_x = ca.hessian(h, x)
    slope = ca.densify(inverse.T @ slope_x)
    if not _is_zero(robot, slope_x - jacobian.T @ slope, slope_x):
        return None
    turning = ca.SX.zeros(x.numel(), x.numel())
    for row, part in zip(ca.vertsplit(quantity), ca.vertsplit(slope), strict=True):
        turning += part * ca.hessian(row, x)[0]
    return slope, ca.densify(inverse.T @ (bend_x - turning) @ inverse), ca.densify(jacobian @ inverse)


def _is_zero(robot: Robot, rest: ca.SX, whole: ca.SX) -> bool:
    """Return whether an expression vanishes at random states, beside another one that does not."""
    system, random = robot.system, np.random.default_rng(1)
    sizes = ca.Function("sizes", [system.x, system.t], [ca.norm_2(ca.densify(rest)), ca.norm_2(ca.densify(whole))])
    found = [tuple(map(float, sizes(x, 0.0))) for x in random.normal(size=(_PROBES, system.n))]
    clear = [(left, size) for left, size in found if np.isfinite(left) and size > 0]
    return bool(clear) and all(left <= _ROUNDING * size for left, size in clear)
