"""The tracking term φ that makes u follow û = u_fb(x) + u_h while v = 0 (paper, proposition 1)."""

import casadi as ca

from passafe.system import System


def nominal_input(u_fb: ca.SX, u_h: ca.SX) -> ca.SX:
    """Return û = u_fb(x) + u_h (paper, equation 2), shape (m, 1)."""
    return u_fb + u_h


def tracking_rate(system: System, u_fb: ca.SX, u_h: ca.SX, u_h_rate: ca.SX, k_i: float) -> ca.SX:
    """Return φ = L_f u_fb + u̇_h + k_i (û − u), shape (m, 1), units of u per second.

    With W = ½‖u − û‖² and v = 0 it gives Ẇ = −2 k_i W (paper, proposition 1, with α = 2 k_i).

    Args:
        system: The plant.
        u_fb: State feedback, expression of x, shape (m, 1).
        u_h: Operator's part, symbol, shape (m, 1).
        u_h_rate: Its time derivative, symbol, shape (m, 1).
        k_i: α/2, 1/s.
    """
    return system.lie_derivative(u_fb) + u_h_rate + k_i * (nominal_input(u_fb, u_h) - system.u)
