"""Barriers of a body's spheres: out of a ball, above a level, apart from one another."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import casadi as ca

from passafe.arguments.ranges import require_positive
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.models.body_sphere import BodySphere
from passafe.models.rotation_bounds import squared_distance_bounds


class BoundedFunction(NamedTuple):
    """A function h with bounds of its time derivatives.

    Attributes:
        h: Scalar expression of x.
        bounds: Of |ḣ|, |ḧ|, ….
    """

    h: ca.SX
    bounds: DerivativeBounds


def ball_keep_out(sphere: BodySphere, *, centre: Sequence[float], radius: float) -> BoundedFunction:
    """Return h = ‖c − centre‖² − (r + radius)², m², of a sphere with centre c and radius r.

    Args:
        sphere: The sphere.
        centre: Centre of the ball, m, three numbers.
        radius: Its radius, m, positive.

    Raises:
        DesignError: A radius that is not positive and finite.
    """
    require_positive("ball radius", radius, "m")
    return _apart(sphere.centre - ca.DM(list(centre)), sphere.radius_m + radius, sphere.bounds)


def above_level(sphere: BodySphere, *, height: float) -> BoundedFunction:
    """Return h = c_z − r − height, m, of a sphere with centre c and radius r.

    Args:
        sphere: The sphere.
        height: Height of the level, m.
    """
    return BoundedFunction(sphere.centre[2] - sphere.radius_m - height, sphere.bounds)


def spheres_apart(first: BodySphere, second: BodySphere) -> BoundedFunction:
    """Return h = ‖c₁ − c₂‖² − (r₁ + r₂)², m², of two spheres of one robot."""
    here, there = first.bounds, second.bounds
    (orders,) = ca.substitute(
        [there.orders], [there.x_size, there.u_size, there.held_s], [here.x_size, here.u_size, here.held_s]
    )
    bounds = replace(here, orders=here.orders + orders)
    return _apart(first.centre - second.centre, first.radius_m + second.radius_m, bounds)


def _apart(between: ca.SX, reach: float, bounds: DerivativeBounds) -> BoundedFunction:
    """Return ‖between‖² − reach² with bounds, which grow from the present distance."""
    largest = ca.norm_2(between) + bounds.held_s * bounds.orders[0]
    orders = squared_distance_bounds(largest, bounds.orders)
    return BoundedFunction(ca.sumsqr(between) - reach**2, replace(bounds, orders=orders))
