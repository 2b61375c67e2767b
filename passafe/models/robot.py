"""What a shipped robot model offers beyond its dynamics."""

from dataclasses import dataclass

import casadi as ca

from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Robot:
    """A plant with the quantities that barriers and feedback are written in, and its own fail-safe.

    Attributes:
        system: The dynamics.
        position: Expression of x, shape (k, 1), m.
        velocity: Expression of x, shape (k, 1), m/s.
        fail_safe: Law u(x) that the robot applies when no input comes, shape (m, 1).
        fail_safe_gain: K of that law.
        fail_safe_condition: The condition under which that law keeps a keep-out disk, in words.
    """

    system: System
    position: ca.SX
    velocity: ca.SX
    fail_safe: ca.SX
    fail_safe_gain: float
    fail_safe_condition: str

    def proportional_derivative(self, *, k_p: float, k_d: float) -> ca.SX:
        """Return u_fb = −k_p·position − k_d·velocity, for robots with one input for each coordinate."""
        return -k_p * self.position - k_d * self.velocity
