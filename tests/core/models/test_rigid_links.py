"""Dynamics of a chain against closed forms, and of the arm against its own energy."""

from math import cos, pi

import casadi as ca
import numpy as np
import pytest

from passafe.errors import DesignError
from passafe.models.joint_chain import joint_chain
from passafe.models.rigid_links import RigidLink, inverse_dynamics, kinetic_energy_of
from passafe.models.serial_chain import RevoluteJoint, SerialChain
from passafe.models.seven_joint_arm import (
    CHAIN,
    GRAVITY_M_S2,
    LINKS,
    joint_accelerations,
    joint_torques,
    seven_joint_arm,
)

MASS, LONG = 2.0, 0.7
PENDULUM = SerialChain(joints=(RevoluteJoint(a_m=0.0, d_m=0.0, alpha_rad=pi / 2),))
BOB = (RigidLink(mass_kg=MASS, centre_m=(LONG, 0.0, 0.0), inertia_kg_m2=(0.0,) * 6, motor_kg_m2=0.3),)
Q, V, A = (ca.SX.sym(name, 7) for name in "qva")
POSE = np.array([0.3, -0.5, 0.2, -2.2, 0.4, 1.7, 0.8])
RATES = np.array([0.5, -1.0, 0.7, 1.2, -0.3, 0.9, -2.0])


def values(expression: ca.SX, *arguments: object) -> np.ndarray:
    return np.array(ca.Function("value", [Q, V, A], [expression])(*arguments)).ravel()


def test_a_pendulum_has_its_textbook_torque() -> None:
    q, v, a = ca.SX.sym("q"), ca.SX.sym("v"), ca.SX.sym("a")
    torque = ca.Function("torque", [q, v, a], [inverse_dynamics(PENDULUM, BOB, q, v, a, 9.81)])
    energy = ca.Function("energy", [q, v], [kinetic_energy_of(PENDULUM, BOB, q, v)])

    inertia = MASS * LONG**2 + 0.3
    assert float(torque(0.4, 1.5, 2.0)) == pytest.approx(inertia * 2.0 + MASS * 9.81 * LONG * cos(0.4), rel=1e-12)
    assert float(energy(0.4, 1.5)) == pytest.approx(inertia * 1.5**2 / 2, rel=1e-12)


def test_the_stretched_arm_reaches_as_far_as_its_table_says() -> None:
    flange = ca.Function("flange", [Q], [CHAIN.frames(Q)[-1].place((0.0, 0.0, 0.107))])

    upright = np.array(flange(np.zeros(7))).ravel()

    assert upright == pytest.approx([0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107], abs=1e-12)


def test_torque_is_what_lagrange_says() -> None:
    energy = kinetic_energy_of(CHAIN, LINKS, Q, V)
    momentum = ca.gradient(energy, V)
    heights = [frame.place(link.centre_m)[2] for frame, link in zip(CHAIN.frames(Q)[1:], LINKS, strict=True)]
    potential = sum((link.mass_kg * GRAVITY_M_S2 * z for link, z in zip(LINKS, heights, strict=True)), ca.SX(0))
    lagrange = ca.jtimes(momentum, Q, V) + ca.jtimes(momentum, V, A) - ca.gradient(energy - potential, Q)

    acceleration = np.linspace(-3.0, 3.0, 7)
    found = values(joint_torques(Q, V, A), POSE, RATES, acceleration)
    assert found == pytest.approx(values(lagrange, POSE, RATES, acceleration), abs=1e-9)


def test_the_port_is_the_arms_momentum() -> None:
    system = seven_joint_arm(sigma=1.0).system
    momentum = ca.Function("momentum", [system.x], [system.port_y])
    M = values(ca.jacobian(ca.gradient(kinetic_energy_of(CHAIN, LINKS, Q, V), V), V), POSE, RATES, RATES)
    M = M.reshape(7, 7)

    assert np.array(momentum(np.concatenate((POSE, RATES)))).ravel() == pytest.approx(M @ RATES, abs=1e-12)
    assert np.linalg.eigvalsh(M).min() > 0.2  # no less than the smallest motor


def test_led_joints_move_the_tip_as_commanded() -> None:
    w = ca.SX.sym("w", 3)
    tip = ca.jacobian(CHAIN.frames(Q)[-1].place((0.0, 0.0, 0.207)), Q)
    led = ca.Function("led", [Q, w], [joint_accelerations(Q, w), tip @ joint_accelerations(Q, w)])

    joints, moved = (np.array(each).ravel() for each in led(POSE, (1.0, 0.0, 0.0)))

    assert moved[0] == pytest.approx(1.0, abs=0.1)  # λ takes some
    assert np.abs(moved[1:]).max() < 0.1
    assert np.array(led(POSE, (0.0,) * 3)[0]).ravel() == pytest.approx(np.zeros(7), abs=0)
    assert np.abs(joints).max() < 5.0


def test_the_arm_moves_as_a_chain_of_joints() -> None:
    arm, chain = seven_joint_arm(sigma=1.5, gamma_1=6.0), joint_chain(sigma=1.5, gamma_1=6.0)
    x, u = np.concatenate((POSE, RATES)), np.linspace(-1.0, 1.0, 7)
    found, expected = (
        ca.Function("rate", [one.system.x, one.system.u], [one.system.f, one.fail_safe]) for one in (arm, chain)
    )

    for made, known in zip(found(x, u), expected(x, u), strict=True):
        assert (np.array(made) == np.array(known)).all()
    assert arm.fail_safe_scope == chain.fail_safe_scope
    slower = arm.system.with_parameters({"mass": 2.0})
    assert np.array(ca.Function("rate", [slower.x, slower.u], [slower.f])(x, u))[7:].ravel() == pytest.approx(
        u / 2 - 1.5 * RATES
    )


def test_a_chain_without_joints_is_refused() -> None:
    with pytest.raises(DesignError, match="serial chain joints: got none, allowed one or more"):
        SerialChain(joints=())
