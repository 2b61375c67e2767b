"""The shipped robots with their dynamics written a second time, in plain numbers: what the suites hold them against."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt

import casadi as ca
import numpy as np
from finite_differences import Array

from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.joint_chain import joint_chain
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.models.saturating_point import saturating_point
from passafe.models.two_points import two_points

SIGMA, DRAG, LAG_S, FORCE, JOINTS = 0.8, 0.5, 0.5, 30.0, 3


@dataclass(frozen=True, kw_only=True)
class Shipped:
    """A shipped robot and what is known of it without it.

    Attributes:
        build: From the first two class-K gains to the robot.
        rate: ẋ for columns of x and u.
        coordinates: k, length of position and of velocity.
        degree: Relative degree of functions of the position; one less for the velocity.
        linear: Whether its steps are exact.
        top_speed: Speed up to which the fail-safe's condition holds, from γ₁.
        input_bound: A bound on every axis of u that is wide, but not beyond all that the drive can follow.
    """

    build: Callable[[float, float], Robot]
    rate: Callable[[Array, Array], Array]
    coordinates: int = 2
    degree: int = 2
    linear: bool = True
    top_speed: Callable[[float], float] = lambda _: inf
    input_bound: float = 1e4


def _damped(x: Array, u: Array) -> Array:
    k = len(u)
    return np.concatenate([x[k:], u - SIGMA * x[k:]])


def _drag(x: Array, u: Array) -> Array:
    v = x[2:]
    return np.concatenate([v, u - SIGMA * v - DRAG * np.hypot(v[0], v[1]) * v])


def _lagged(x: Array, u: Array) -> Array:
    v, w = x[2:4], x[4:]
    return np.concatenate([v, w - SIGMA * v, (u - w) / LAG_S])


def _saturating(x: Array, u: Array) -> Array:
    v = x[2:]
    return np.concatenate([v, u * FORCE / np.sqrt(FORCE**2 + u[0] ** 2 + u[1] ** 2) - SIGMA * v])


ROBOTS: dict[str, Shipped] = {
    "damped point": Shipped(
        build=lambda gamma_1, _: damped_point(sigma=SIGMA, gamma_1=gamma_1),
        rate=_damped,
    ),
    "drag point": Shipped(
        build=lambda gamma_1, _: drag_point(sigma=SIGMA, drag=DRAG, gamma_1=gamma_1),
        rate=_drag,
        linear=False,
    ),
    "lagged point": Shipped(
        build=lambda gamma_1, gamma_2: lagged_point(sigma=SIGMA, lag_s=LAG_S, gamma_1=gamma_1, gamma_2=gamma_2),
        rate=_lagged,
        degree=3,
    ),
    "saturating point": Shipped(
        build=lambda gamma_1, _: saturating_point(sigma=SIGMA, force=FORCE, gamma_1=gamma_1),
        rate=_saturating,
        linear=False,
        top_speed=lambda gamma_1: sqrt(0.75) * FORCE / (gamma_1 - SIGMA) if gamma_1 > SIGMA else inf,
        input_bound=FORCE / 2,
    ),
    "two points": Shipped(
        build=lambda gamma_1, _: two_points(sigma=SIGMA, gamma_1=gamma_1),
        rate=_damped,
        coordinates=4,
    ),
    "joint chain": Shipped(
        build=lambda gamma_1, _: joint_chain(joints=JOINTS, sigma=SIGMA, gamma_1=gamma_1),
        rate=_damped,
        coordinates=JOINTS,
    ),
}

IN_THE_PLANE = ("damped point", "drag point", "lagged point", "saturating point")


def columns(arguments: list[ca.SX], expression: ca.SX) -> Callable[..., Array]:
    """Return an expression as a function of arrays with one column a sample."""
    function = ca.Function("columns", arguments, [ca.densify(expression)])

    def evaluate(*values: Array) -> Array:
        samples = max(value.shape[1] for value in values)
        given = [np.broadcast_to(value, (value.shape[0], samples)) for value in values]
        return np.asarray(function(*(ca.DM(value) for value in given)).full())

    return evaluate
