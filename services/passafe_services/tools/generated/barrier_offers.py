"""Random safe sets for coordinates, planes and speeds."""

import casadi as ca
import numpy as np

from passafe.barriers import disk_keep_in, disk_keep_out, half_plane, speed_limit
from passafe_services.tools.generated.generated_plant import BarrierOffer
from passafe_services.tools.generated.random_numbers import one_of


def between(name: str, q: ca.SX, limit: float, degree: int) -> tuple[BarrierOffer, BarrierOffer]:
    """Return q ≥ −limit and q ≤ limit.

    Args:
        name: Of the coordinate.
        q: Coordinate, scalar.
        limit: Positive, units of q.
        degree: Relative degree of q.
    """
    below = BarrierOffer(name=f"{name}-above", h=q + limit, degree=degree)
    return below, BarrierOffer(name=f"{name}-below", h=limit - q, degree=degree)


def product(name: str, q: ca.SX, limit: float, degree: int) -> BarrierOffer:
    """Return (limit − q)(limit + q) ≥ 0, one barrier for both sides, whose gradient vanishes half-way."""
    return BarrierOffer(name=name, h=(limit - q) * (limit + q), degree=degree)


def in_the_plane(rng: np.random.Generator, position: ca.SX, degree: int) -> tuple[BarrierOffer, ...]:
    """Draw walls or disks around a position in the plane, the origin inside of all of them.

    Args:
        rng: Source.
        position: Shape (2, 1), m.
        degree: Relative degree of the position.
    """
    kind = one_of(rng, ("wall", "room", "disk", "two-disks", "arena"))
    if kind == "wall":
        angle = rng.uniform(0, 2 * np.pi)
        wall = half_plane(position, normal=(-np.cos(angle), -np.sin(angle)), offset=-rng.uniform(0.8, 2.0))
        return (BarrierOffer(name="wall", h=wall, degree=degree),)
    if kind == "room":
        sides = [between(f"side-{i}", position[i], rng.uniform(1.0, 2.0), degree) for i in range(2)]
        return (*sides[0], *sides[1])
    if kind == "arena":
        arena = disk_keep_in(position, centre=(0.0, 0.0), radius=rng.uniform(1.2, 2.2))
        return (BarrierOffer(name="arena", h=arena, degree=degree),)
    return tuple(_disk(rng, position, degree, i) for i in range(2 if kind == "two-disks" else 1))


def speed_at_most(name: str, velocity: ca.SX, limit: float, degree: int = 1) -> BarrierOffer:
    """Return ‖velocity‖ ≤ limit."""
    return BarrierOffer(name=name, h=speed_limit(velocity, limit=limit), degree=degree)


def _disk(rng: np.random.Generator, position: ca.SX, degree: int, i: int) -> BarrierOffer:
    radius, angle = rng.uniform(0.2, 0.8), rng.uniform(0, np.pi) + np.pi * i
    away = radius + rng.uniform(0.4, 1.2)
    h = disk_keep_out(position, centre=(away * np.cos(angle), away * np.sin(angle)), radius=radius)
    return BarrierOffer(name=f"disk-{i}", h=h, degree=degree)
