"""The rule of ``docs/feasibility.md``: braking keeps the rows of all convex barriers that stand still, at once."""

import casadi as ca
import numpy as np
import pytest
from shipped_robots import ROBOTS, columns

from passafe.barrier_chain import Barrier, derive_chain
from passafe.barriers import box, disk_keep_out, ellipse_keep_out, separation, speed_limit
from passafe.class_k import Linear
from passafe.models.robot import Robot

GAINS = ((4.0, 5.0), (3.0, 2.5), (2.0, 6.0))
"""γ₁ and γ₂ of the barriers in turn; the largest γ₁ is below every γ₁ + γ₂."""


def many_barriers(robot: Robot) -> list[Barrier]:
    first = robot.position[:2] if robot.points else robot.position
    shapes = [*box(robot.position, low=[-3.0] * robot.position.numel(), high=[2.5] * robot.position.numel())]
    if robot.points:
        shapes += [
            disk_keep_out(first, centre=(0.0, 0.5), radius=0.7),
            disk_keep_out(first, centre=(1.5, -1.0), radius=0.5),
            ellipse_keep_out(first, centre=(-1.0, -1.0), semi_axes=(0.8, 0.3), rotation_rad=0.4),
        ]
    if robot.points == 2:
        shapes.append(separation(first, robot.position[2:], distance=0.6))
    places = [
        Barrier(name=f"{i}", h=h, class_k=tuple(Linear(gain=gain) for gain in (*GAINS[i % 3], 1.0)))
        for i, h in enumerate(shapes)
    ]
    speed = Barrier(name="speed", h=speed_limit(robot.velocity, limit=3.0), class_k=(Linear(gain=2.0),) * 2)
    return [*places, speed]


@pytest.mark.parametrize("name", ["damped point", "drag point", "two points", "joint chain"])
@pytest.mark.parametrize("kappa", [4.0, 5.0, 5.5])
def test_braking_keeps_every_row_at_once(name: str, kappa: float) -> None:
    robot = ROBOTS[name].build(4.0, 0.0)
    system = robot.system
    chains = [derive_chain(system, barrier) for barrier in many_barriers(robot)]
    before = columns([system.x], ca.vertcat(*(psi for chain in chains for psi in chain.psi[:-1])))
    last = columns([system.x, system.u], ca.vertcat(*(chain.psi[-1] for chain in chains)))
    x = np.random.default_rng(11).uniform(-2.5, 2.5, (system.n, 20_000))
    x = x[:, before(x).min(axis=0) >= 0]
    velocity, still = x[system.m :], np.zeros((system.m, x.shape[1]))
    u = -kappa * velocity - ROBOTS[name].rate(x, still)[system.m :]

    assert x.shape[1] > 50
    assert last(x, u).min() >= -1e-9
    assert last(x, 0 * u).min() < -1  # without braking some row is lost
