"""Barrier functions of common safe sets, as expressions of a position."""

from collections.abc import Sequence
from math import inf, isfinite

import casadi as ca

from passafe.errors import DesignError, ShapeError


def disk_keep_out(position: ca.SX, *, centre: Sequence[float], radius: float) -> ca.SX:
    """Return h = ‖p − centre‖² − radius²: non-negative outside a disk or ball (paper, section 4).

    Args:
        position: p, shape (k, 1), m.
        centre: k numbers, m.
        radius: Positive, m.
    """
    _require_length("disk centre", centre, position)
    if not 0 < radius < inf:
        raise DesignError("disk radius", radius, "a positive finite number, m")
    return ca.sumsqr(position - ca.DM(list(centre))) - radius**2


def half_plane(position: ca.SX, *, normal: Sequence[float], offset: float) -> ca.SX:
    """Return h = normalᵀp − offset: non-negative on the side that ``normal`` points to.

    Args:
        position: p, shape (k, 1), m.
        normal: k numbers, not all zero.
        offset: Units of normalᵀp.
    """
    _require_length("half-plane normal", normal, position)
    if not any(normal):
        raise DesignError("half-plane normal", list(normal), "a vector that is not zero")
    if not isfinite(offset):
        raise DesignError("half-plane offset", offset, "a finite number")
    return ca.dot(ca.DM(list(normal)), position) - offset


def _require_length(part: str, vector: Sequence[float], position: ca.SX) -> None:
    if len(vector) != position.numel():
        raise ShapeError(part, f"{len(vector)} numbers", f"{position.numel()}, one for each coordinate")
    if not all(map(isfinite, vector)):
        raise DesignError(part, list(vector), "finite numbers")
