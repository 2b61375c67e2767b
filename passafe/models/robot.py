"""A robot model: its dynamics, the quantities for barriers and feedback, and its fail-safe law."""

from dataclasses import dataclass

import casadi as ca

from passafe.derivative_bounds import DerivativeBounds
from passafe.models.body_sphere import BodySphere
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Robot:
    """A plant with the quantities that barriers and feedback are written in, and its own fail-safe.

    x begins with all positions, followed by all velocities.

    Attributes:
        system: The dynamics.
        position: Expression of x, shape (k, 1), m; rad for joints.
        velocity: Expression of x, shape (k, 1), m/s; rad/s for joints.
        points: How many points in the plane the position is made of; 0 where it is no place, as with joints.
        fail_safe: Law u(x) that the robot applies when no input comes, shape (m, 1).
        fail_safe_gain: K, by which that law multiplies −velocity, 1/s or equivalent.
        fail_safe_scope: The barriers that law keeps, in numbers.
        stopping_hull: Positions as expressions of x, each of shape (k, 1). While that law is in force the position
            never leaves their convex hull, under ``fail_safe_condition``.
        fail_safe_condition: The condition under which that law keeps a barrier, in words.
        storage: Its own storage function V, scalar expression of x, J, or none.
        power_bounds: Bounds of the first two derivatives of the power margin with that storage, or none.
        spheres: Spheres that cover its body, in space.
    """

    system: System
    position: ca.SX
    velocity: ca.SX
    points: int
    fail_safe: ca.SX
    fail_safe_gain: float
    fail_safe_scope: FailSafeScope
    stopping_hull: tuple[ca.SX, ...]
    fail_safe_condition: str
    storage: ca.SX | None = None
    power_bounds: DerivativeBounds | None = None
    spheres: tuple[BodySphere, ...] = ()

    def proportional_derivative(self, *, k_p: float, k_d: float) -> ca.SX:
        """Return u_fb = −k_p·position − k_d·velocity, for robots with one input for each coordinate."""
        return -k_p * self.position - k_d * self.velocity
