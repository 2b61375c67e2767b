"""A seven-joint arm on a table: kinematics, masses and limits of the Franka Emika Panda, from published values.

Kinematics and limits are the maker's (Denavit–Hartenberg table and limits of its control interface); masses are those
that Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca identified (IEEE Robotics and Automation Letters 4(4), 2019);
the inertia of the motors is the maker's for the successor FR3, which the identification does not separate.
"""

from dataclasses import dataclass, replace
from math import pi
from typing import Final

import casadi as ca

from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.models.body_sphere import BodySphere
from passafe.models.braking import braking_robot
from passafe.models.drawing import Drawing
from passafe.models.energy_bounds import power_margin_bounds
from passafe.models.rigid_links import RigidLink, inverse_dynamics, kinetic_energy_of
from passafe.models.robot import Robot
from passafe.models.rotation_bounds import vector_bounds
from passafe.models.serial_chain import RevoluteJoint, SerialChain
from passafe.models.task_frame import TaskFrame

JOINTS: Final = 7

CHAIN: Final = SerialChain(
    joints=(
        RevoluteJoint(a_m=0.0, d_m=0.333, alpha_rad=0.0),
        RevoluteJoint(a_m=0.0, d_m=0.0, alpha_rad=-pi / 2),
        RevoluteJoint(a_m=0.0, d_m=0.316, alpha_rad=pi / 2),
        RevoluteJoint(a_m=0.0825, d_m=0.0, alpha_rad=pi / 2),
        RevoluteJoint(a_m=-0.0825, d_m=0.384, alpha_rad=-pi / 2),
        RevoluteJoint(a_m=0.0, d_m=0.0, alpha_rad=pi / 2),
        RevoluteJoint(a_m=0.088, d_m=0.0, alpha_rad=pi / 2),
    )
)
"""Kinematics up to link 7, whose flange is 0.107 m along its z."""

LINKS: Final = (
    RigidLink(
        mass_kg=4.970684,
        centre_m=(3.875e-3, 2.081e-3, -4.762e-2),
        inertia_kg_m2=(7.0337e-1, -1.39e-4, 6.772e-3, 7.0661e-1, 1.9169e-2, 9.117e-3),
        motor_kg_m2=0.605721,
    ),
    RigidLink(
        mass_kg=0.646926,
        centre_m=(-3.141e-3, -2.872e-2, 3.495e-3),
        inertia_kg_m2=(7.962e-3, -3.925e-3, 1.0254e-2, 2.811e-2, 7.04e-4, 2.5995e-2),
        motor_kg_m2=0.605721,
    ),
    RigidLink(
        mass_kg=3.228604,
        centre_m=(2.7518e-2, 3.9252e-2, -6.6502e-2),
        inertia_kg_m2=(3.7242e-2, -4.761e-3, -1.1396e-2, 3.6155e-2, -1.2805e-2, 1.083e-2),
        motor_kg_m2=0.462474,
    ),
    RigidLink(
        mass_kg=3.587895,
        centre_m=(-5.317e-2, 1.04419e-1, 2.7454e-2),
        inertia_kg_m2=(2.5853e-2, 7.796e-3, -1.332e-3, 1.9552e-2, 8.641e-3, 2.8323e-2),
        motor_kg_m2=0.462474,
    ),
    RigidLink(
        mass_kg=1.225946,
        centre_m=(-1.1953e-2, 4.1065e-2, -3.8437e-2),
        inertia_kg_m2=(3.5549e-2, -2.117e-3, -4.037e-3, 2.9474e-2, 2.29e-4, 8.627e-3),
        motor_kg_m2=0.205544,
    ),
    RigidLink(
        mass_kg=1.666555,
        centre_m=(6.0149e-2, -1.4117e-2, -1.0517e-2),
        inertia_kg_m2=(1.964e-3, 1.09e-4, -1.158e-3, 4.354e-3, 3.41e-4, 5.433e-3),
        motor_kg_m2=0.205544,
    ),
    RigidLink(
        mass_kg=7.35522e-1,
        centre_m=(1.0517e-2, -4.252e-3, 6.1597e-2),
        inertia_kg_m2=(1.2516e-2, -4.28e-4, -1.196e-3, 1.0027e-2, -7.41e-4, 4.815e-3),
        motor_kg_m2=0.205544,
    ),
)
"""Masses of links 1 to 7."""

ANGLE_LOW: Final = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
ANGLE_HIGH: Final = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
"""Limits of the angles, rad."""

TOP_SPEED: Final = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)
"""Limits of their rates, rad/s."""

TOP_ACCELERATION: Final = (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0)
"""Limits of their second derivatives, rad/s²."""

TOP_TORQUE: Final = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""Limits of the torques, N·m."""

GRAVITY_M_S2: Final = 9.81

TIP_M: Final = (0.0, 0.0, 0.207)
"""The tip in link 7's frame: a tool of 0.1 m on the flange."""

DAMPING: Final = 1e-2
"""λ of the least-squares inverse that leads the tip, m²: near a singular pose the joints move less instead of more."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SpherePlace:
    """Place of one sphere of the body.

    Attributes:
        link: Number of the link that carries it.
        offset_m: Centre in that link's frame, m.
        radius_m: Radius, m.
    """

    link: int
    offset_m: tuple[float, float, float]
    radius_m: float


SPHERES: Final = {
    "upper arm 1": SpherePlace(link=2, offset_m=(0.0, -0.12, 0.0), radius_m=0.085),
    "upper arm 2": SpherePlace(link=2, offset_m=(0.0, -0.24, 0.0), radius_m=0.085),
    "elbow": SpherePlace(link=3, offset_m=(0.041, 0.0, 0.0), radius_m=0.08),
    "forearm 1": SpherePlace(link=4, offset_m=(-0.0825, 0.06, 0.0), radius_m=0.08),
    "forearm 2": SpherePlace(link=4, offset_m=(-0.0825, 0.17, 0.0), radius_m=0.08),
    "forearm 3": SpherePlace(link=4, offset_m=(-0.0825, 0.28, 0.0), radius_m=0.08),
    "wrist": SpherePlace(link=5, offset_m=(0.0, 0.0, 0.0), radius_m=0.08),
    "hand": SpherePlace(link=6, offset_m=(0.07, 0.0, 0.0), radius_m=0.075),
    "tool": SpherePlace(link=7, offset_m=(0.0, 0.0, 0.1), radius_m=0.06),
    "tip": SpherePlace(link=7, offset_m=(0.0, 0.0, 0.17), radius_m=0.055),
}
"""Spheres that cover the arm from the middle of its upper arm to its tip."""


def seven_joint_arm(*, sigma: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0) -> Robot:
    """Return q̈ = −σq̇ + u, x = (q, q̇), with the physical port: its output is M(q)q̇, so that yᵀu = q̇ᵀMu is a power.

    A driver with a torque interface makes the joints follow that by computed torque, τ = M(q)(u − σq̇) + C(q, q̇)q̇ +
    g(q) (``joint_torques``). Angles and places of the spheres have relative degree 2, rates 1. The fail-safe is
    u = −Kq̇ with K = max(γ₁ − σ, 0); what it keeps of the angles' limits, and why, is in ``passafe.models.braking``.
    Nothing is stated about places: a straight way of the joints is a curved one of the tip. It is commanded by the
    acceleration of its tip in the base's frame.

    Args:
        sigma: Damping σ of each joint, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    robot = braking_robot("arm", axes=JOINTS, points=0, sigma=sigma, gamma_1=gamma_1, dt_s=dt_s)
    system, q, v = robot.system, robot.position, robot.velocity
    energy = kinetic_energy_of(CHAIN, LINKS, q, v)
    momentum, sizes, w = ca.gradient(energy, v), _Sizes.of(sigma), ca.SX.sym("w", 3)
    return replace(
        robot,
        system=replace(system, f=system.general_f, port_y=momentum, port_u=system.u),
        storage=energy,
        power_bounds=sizes.bounds(power_margin_bounds(CHAIN, LINKS, sizes.rates, sizes.u_size)),
        spheres=_spheres(q, sizes),
        task=TaskFrame(command=w, u_h=joint_accelerations(q, w), axes=("x", "y", "z")),
        state_units=("rad",) * JOINTS + ("rad/s",) * JOINTS,
        drawing=_drawing(q),
        input_unit="rad/s²",
    )


def joint_torques(q: ca.SX, v: ca.SX, acceleration: ca.SX) -> ca.SX:
    """Return the torques that give the arm an acceleration, N·m, shape (7, 1): computed torque.

    Args:
        q: Angles, rad, shape (7, 1).
        v: Their rates, rad/s, shape (7, 1).
        acceleration: Wanted, rad/s², shape (7, 1).
    """
    return inverse_dynamics(CHAIN, LINKS, q, v, acceleration, GRAVITY_M_S2)


def joint_accelerations(q: ca.SX, tip_acceleration: ca.SX) -> ca.SX:
    """Return accelerations of the joints that lead the tip, rad/s², shape (7, 1): damped least squares.

    Args:
        q: Angles, rad, shape (7, 1).
        tip_acceleration: Wanted in the base's frame, m/s², shape (3, 1); what turning joints add by themselves is left
            to the person who steers.
    """
    J = ca.jacobian(CHAIN.frames(q)[-1].place(TIP_M), q)
    return J.T @ _solved(J @ J.T + DAMPING * ca.DM.eye(3), tip_acceleration)


def _solved(A: ca.SX, b: ca.SX) -> ca.SX:
    """Return A⁻¹b of a symmetric matrix, by its cofactors; shape (3, 1)."""
    rows = [A[i, :].T for i in range(3)]
    cofactors = ca.horzcat(*(ca.cross(rows[(i + 1) % 3], rows[(i + 2) % 3]) for i in range(3)))
    return cofactors @ b / ca.dot(rows[0], cofactors[:, 0])


def _drawing(q: ca.SX) -> Drawing:
    """Return the arm as links from joint to joint, in space."""
    frames = CHAIN.frames(q)
    bend = frames[4].place((-0.0825, 0.0, 0.0))
    origins = [frames[0].origin, *(frames[i].origin for i in (1, 3, 4)), bend, *(frames[i].origin for i in (5, 7))]
    points = [*origins, frames[7].place(TIP_M)]
    links = tuple((i, i + 1) for i in range(len(points) - 1))
    return Drawing(points=ca.vertcat(*points), dimensions=3, links=links)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Sizes:
    """Symbols of the bounds: how large states and inputs can become while an input is held.

    Attributes:
        x_size: Largest |x|, shape (14, 1).
        u_size: Largest |u|, shape (7, 1).
        held_s: How long it is held, s.
        rates: Bounds of the first four derivatives of the angles, shape (4, 7).
    """

    x_size: ca.SX
    u_size: ca.SX
    held_s: ca.SX
    rates: ca.SX

    @classmethod
    def of(cls, sigma: float) -> "_Sizes":
        """Return the symbols with q̈ = u − σq̇, q⃛ = −σq̈ and q⁗ = σ²q̈, as u is held."""
        x_size, u_size, held_s = ca.SX.sym("x_size", 2 * JOINTS), ca.SX.sym("u_size", JOINTS), ca.SX.sym("held_s")
        speed, pushed = x_size[JOINTS:].T, (u_size + sigma * x_size[JOINTS:]).T
        rates = ca.vertcat(speed, pushed, sigma * pushed, sigma**2 * pushed)
        return cls(x_size=x_size, u_size=u_size, held_s=held_s, rates=rates)

    def bounds(self, orders: ca.SX) -> DerivativeBounds:
        """Return bounds in these symbols."""
        return DerivativeBounds(x_size=self.x_size, u_size=self.u_size, held_s=self.held_s, orders=orders)


def _spheres(q: ca.SX, sizes: _Sizes) -> tuple[BodySphere, ...]:
    """Return the spheres with the bounds of their motion."""
    frames = CHAIN.frames(q)
    return tuple(
        BodySphere(
            name=name,
            centre=frames[place.link].place(place.offset_m),
            radius_m=place.radius_m,
            bounds=sizes.bounds(vector_bounds(CHAIN.lengths(place.link, place.offset_m), sizes.rates)),
        )
        for name, place in SPHERES.items()
    )
