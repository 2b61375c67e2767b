"""Dynamics of a chain of rigid links: kinetic energy and inverse dynamics, by recursion from link to link.

Craig 2005, chapter 6 (Newton–Euler). Vectors of a link are in its own frame, and its inertia is about its centre of
mass. What turns with a joint's motor counts as inertia about the joint's axis alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca

from passafe.models.serial_chain import SerialChain, turn


@dataclass(frozen=True, kw_only=True, slots=True)
class RigidLink:
    """Mass of one link.

    Attributes:
        mass_kg: Mass, kg.
        centre_m: Centre of mass in the link's frame, m, three numbers.
        inertia_kg_m2: Ixx, Ixy, Ixz, Iyy, Iyz, Izz about that centre, kg·m².
        motor_kg_m2: Inertia of the joint's motor about the joint's axis, kg·m².
    """

    mass_kg: float
    centre_m: tuple[float, float, float]
    inertia_kg_m2: tuple[float, float, float, float, float, float]
    motor_kg_m2: float = 0.0

    @property
    def inertia(self) -> ca.DM:
        """Return the inertia tensor, shape (3, 3)."""
        xx, xy, xz, yy, yz, zz = self.inertia_kg_m2
        return ca.DM([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class _LinkMotion(NamedTuple):
    """Motion of a link in its own frame.

    Attributes:
        rotation: Of the link in the frame of the one before, shape (3, 3).
        spin: Angular velocity.
        spin_rate: Its rate.
        speed: Velocity of the origin.
        push: Acceleration of the origin, gravity included.
    """

    rotation: ca.SX
    spin: ca.SX
    spin_rate: ca.SX
    speed: ca.SX
    push: ca.SX


_Z = ca.DM([0, 0, 1])


def kinetic_energy_of(chain: SerialChain, links: Sequence[RigidLink], q: ca.SX, v: ca.SX) -> ca.SX:
    """Return ½q̇ᵀM(q)q̇, J; its gradient in v is M(q)q̇.

    Args:
        chain: Kinematics.
        links: Masses of links 1 to k.
        q: Angles, rad, shape (k, 1).
        v: Their rates, rad/s, shape (k, 1).
    """
    energy = ca.SX(0)
    still = ca.SX.zeros(v.numel())
    for i, (link, motion) in enumerate(zip(links, _motions(chain, q, v, still, 0.0), strict=True)):
        speed = motion.speed + ca.cross(motion.spin, ca.DM(link.centre_m))
        turning = ca.dot(motion.spin, link.inertia @ motion.spin)
        energy += (link.mass_kg * ca.sumsqr(speed) + turning + link.motor_kg_m2 * v[i] ** 2) / 2
    return energy


def inverse_dynamics(
    chain: SerialChain, links: Sequence[RigidLink], q: ca.SX, v: ca.SX, acceleration: ca.SX, gravity_m_s2: float
) -> ca.SX:
    """Return τ = M(q)q̈ + C(q, q̇)q̇ + g(q), N·m, shape (k, 1).

    Args:
        chain: Kinematics; z of the base points up.
        links: Masses of links 1 to k.
        q: Angles, rad, shape (k, 1).
        v: Their rates, rad/s, shape (k, 1).
        acceleration: q̈, rad/s², shape (k, 1).
        gravity_m_s2: Magnitude of gravity, m/s².
    """
    motions = tuple(_motions(chain, q, v, acceleration, gravity_m_s2))
    force, moment, torques = ca.SX.zeros(3), ca.SX.zeros(3), []
    for i in reversed(range(len(links))):
        link, motion = links[i], motions[i]
        centre = ca.DM(link.centre_m)
        push = motion.push + ca.cross(motion.spin_rate, centre) + _towards(motion.spin, centre)
        own_force = link.mass_kg * push
        own_moment = link.inertia @ motion.spin_rate + ca.cross(motion.spin, link.inertia @ motion.spin)
        if i + 1 < len(links):
            rotated = motions[i + 1].rotation @ force
            moment = motions[i + 1].rotation @ moment + ca.cross(chain.joints[i + 1].origin, rotated)
            force = rotated
        moment = moment + own_moment + ca.cross(centre, own_force)
        force = force + own_force
        torques.append(moment[2] + link.motor_kg_m2 * acceleration[i])
    return ca.vertcat(*reversed(torques))


def _motions(chain: SerialChain, q: ca.SX, v: ca.SX, acceleration: ca.SX, gravity_m_s2: float) -> Iterator[_LinkMotion]:
    spin, spin_rate, speed = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX.zeros(3)
    push = ca.SX(ca.DM([0, 0, gravity_m_s2]))
    for i, joint in enumerate(chain.joints):
        rotation = ca.sparsify(joint.twist @ turn(q[i]))
        speed = rotation.T @ (speed + ca.cross(spin, joint.origin))
        push = rotation.T @ (push + ca.cross(spin_rate, joint.origin) + _towards(spin, joint.origin))
        carried = rotation.T @ spin
        spin_rate = rotation.T @ spin_rate + ca.cross(carried, _Z * v[i]) + _Z * acceleration[i]
        spin = carried + _Z * v[i]
        yield _LinkMotion(rotation, spin, spin_rate, speed, push)


def _towards(spin: ca.SX, arm: ca.DM) -> ca.SX:
    """Return ω × (ω × r)."""
    return ca.cross(spin, ca.cross(spin, arm))
