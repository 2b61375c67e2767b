"""Bounds of the time derivatives of an arm's power margin, by the rates of its joints alone.

h_u = yᵀu − V̇ with V = Σ ½m‖ċ‖² + ½ωᵀIω + ½Jq̇² over the links and yᵀu = Σ m ċᵀ(∂c/∂q)u + ωᵀI(∂ω/∂q̇)u + Jq̇u. The centres'
velocities and the angular velocities are vectors that the joints turn (``passafe.models.rotation_bounds``), and so are
their derivatives along u: joint j turns what lies beyond it, so that the k-th derivative of (∂c/∂q)u is no longer than
Σ |lᵢ| Uᵢ Bₖ with Uᵢ = Σ|uⱼ| over the joints that turn lᵢ.
"""

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca

from passafe.models.rigid_links import RigidLink
from passafe.models.rotation_bounds import rotation_bounds, vector_bounds
from passafe.models.serial_chain import SerialChain
from passafe.numerics.fixed_order import spectral_radius


class _Growth(NamedTuple):
    """Bounds of a velocity's first derivatives, itself first, and of those of its change along u."""

    velocity: ca.SX
    along_u: ca.SX


def power_margin_bounds(chain: SerialChain, links: Sequence[RigidLink], rates: ca.SX, u_size: ca.SX) -> ca.SX:
    """Return bounds of the first two derivatives of the power margin under a held input, W/s and W/s², shape (2, 1).

    Args:
        chain: Kinematics.
        links: Masses of links 1 to k.
        rates: Bounds of the first four derivatives of each angle, shape (4, k).
        u_size: Bounds of |u|, shape (k, 1).
    """
    total = ca.SX.zeros(2)
    for i, link in enumerate(links, 1):
        moved = _moved(chain.lengths(i, link.centre_m), rates, u_size)
        turned = _moved((*(0.0,) * (i - 1), 1.0), rates, u_size)
        joint = _Growth(rates[:, i - 1], ca.vertcat(u_size[i - 1], 0, 0))
        largest = spectral_radius(link.inertia.full())
        for weight, growth in ((link.mass_kg, moved), (largest, turned), (link.motor_kg_m2, joint)):
            total += weight * _of_energy(growth)
    return total


def _moved(lengths: Sequence[float], rates: ca.SX, u_size: ca.SX) -> _Growth:
    along, summed, reach = ca.SX.zeros(3), ca.SX.zeros(4), ca.SX(0)
    for joint, length in enumerate(lengths):
        summed, reach = summed + rates[:, joint], reach + u_size[joint]
        if length:
            along += length * reach * ca.vertcat(1, rotation_bounds(*ca.vertsplit(summed))[:2])
    return _Growth(vector_bounds(lengths, rates), along)


def _of_energy(growth: _Growth) -> ca.SX:
    """Return bounds of the first two derivatives of vᵀv′ − d/dt ½‖v‖², v′ being along u, shape (2, 1)."""
    v0, v1, v2, v3 = ca.vertsplit(growth.velocity)
    e0, e1, e2 = ca.vertsplit(growth.along_u)
    first = v1 * e0 + v0 * e1 + v0 * v2 + v1**2
    second = v2 * e0 + 2 * v1 * e1 + v0 * e2 + v0 * v3 + 3 * v1 * v2
    return ca.vertcat(first, second)
