"""Bounds of the time derivatives of vectors that joints turn, by the rates of the joints alone.

Let v = R₁(q₁)⋯Rᵢ(qᵢ)l with rotations about unit axes. The k-th derivative of Rⱼ(qⱼ(t)) is no longer than that of
exp(φⱼ(t)) at 0 for any φⱼ whose derivatives are no smaller than |q̇ⱼ|, |q̈ⱼ|, …, and so is a product: with
w = Σ|q̇ⱼ|, a = Σ|q̈ⱼ|, j = Σ|q⃛ⱼ|, s = Σ|q⁗ⱼ| over the joints that turn l,

    |v⁽ᵏ⁾| ≤ |l|·Bₖ,  B₁ = w,  B₂ = w² + a,  B₃ = w³ + 3wa + j,  B₄ = w⁴ + 6w²a + 3a² + 4wj + s

(Bell's polynomials). A body's angular velocity in its own frame is Σ (Rⱼ₊₁⋯Rᵢ)ᵀ zⱼ q̇ⱼ, whose k-th derivative is
no longer than Bₖ₊₁: that of a vector of unit length.
"""

from collections.abc import Sequence
from typing import Final

import casadi as ca

ORDERS: Final = 4
"""Number of derivatives that are bounded."""


def rotation_bounds(w: ca.SX, a: ca.SX, j: ca.SX, s: ca.SX) -> ca.SX:
    """Return B₁ … B₄ for sums of the first four derivatives of the angles, shape (4, 1)."""
    return ca.vertcat(w, w**2 + a, w**3 + 3 * w * a + j, w**4 + 6 * w**2 * a + 3 * a**2 + 4 * w * j + s)


def vector_bounds(lengths: Sequence[float], rates: ca.SX) -> ca.SX:
    """Return bounds of the first four derivatives of Σ R₁⋯Rᵢ lᵢ, shape (4, 1).

    Args:
        lengths: |lᵢ| for i = 1, 2, …, m; as many as joints that count.
        rates: Bounds of the first four derivatives of each angle, shape (4, joints).
    """
    total, summed = ca.SX.zeros(ORDERS), ca.SX.zeros(ORDERS)
    for joint, length in enumerate(lengths):
        summed = summed + rates[:, joint]
        if length:
            total += length * rotation_bounds(*ca.vertsplit(summed))
    return total


def squared_distance_bounds(distance: ca.SX, orders: ca.SX) -> ca.SX:
    """Return bounds of the first four derivatives of ‖v‖², shape (4, 1).

    Args:
        distance: Largest ‖v‖ meanwhile, scalar.
        orders: Bounds of the first four derivatives of v, shape (4, 1).
    """
    d1, d2, d3, d4 = ca.vertsplit(orders)
    return 2 * ca.vertcat(
        distance * d1,
        distance * d2 + d1**2,
        distance * d3 + 3 * d1 * d2,
        distance * d4 + 4 * d1 * d3 + 3 * d2**2,
    )
