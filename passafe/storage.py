"""Storage functions V(x): what energy the passivity row is about."""

import casadi as ca

from passafe.arguments.ranges import require_positive


def squared_norm(x: ca.SX) -> ca.SX:
    """Return V = ‖x‖²: the paper's (section 4), which charges for distance from the origin as well as for speed.

    Args:
        x: The whole state, shape (n, 1).
    """
    return ca.sumsqr(x)


def kinetic_energy(velocity: ca.SX) -> ca.SX:
    """Return V = ½‖v‖², J for each kg: position costs nothing.

    Args:
        velocity: v, shape (k, 1), m/s.
    """
    return ca.sumsqr(velocity) / 2


def spring_energy(position: ca.SX, velocity: ca.SX, *, stiffness: float) -> ca.SX:
    """Return V = ½‖v‖² + ½k‖p‖², J for each kg: that of a mass on a spring to the origin.

    Args:
        position: p, shape (j, 1), m.
        velocity: v, shape (j, 1), m/s.
        stiffness: k, positive, 1/s².

    Raises:
        DesignError: A stiffness that is not positive and finite.
    """
    require_positive("spring stiffness", stiffness, "1/s²")
    return kinetic_energy(velocity) + stiffness * ca.sumsqr(position) / 2
