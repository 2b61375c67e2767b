"""Limits of two axes that are neither symmetric nor boxes, and what inputs of a design they belong to."""

from dataclasses import replace

import numpy as np

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.design import FilterDesign
from passafe.limits import Limits
from passafe.numerics.workspace import Array

LIMIT_SETS: dict[str, dict[str, object]] = {
    "thrust that only pushes": {"input_bound": None, "input_low": (0.0, -3.0), "input_high": (9.0, 5.0)},
    "zero outside": {"input_bound": None, "input_low": (2.0, -3.0), "input_high": (9.0, -1.0)},
    "a polytope": {
        "input_bound": 20.0,
        "input_half_spaces": (HalfSpace(weights=(2.0, 2.0), bound=20.0), HalfSpace(weights=(-1.0, 2.0), bound=6.0)),
    },
    "a strip away from zero": {
        "input_bound": 20.0,
        "input_half_spaces": (HalfSpace(weights=(-1.0, -1.0), bound=-10.0), HalfSpace(weights=(1.0, 1.0), bound=12.0)),
    },
    "norms of parts": {
        "input_bound": 20.0,
        "input_norms": (
            NormBound(axes=(1,), bound=5.0),
            NormBound(axes=(0, 1), bound=9.0),
            NormBound(axes=(0,), bound=8.5),
        ),
    },
    "everything": {
        "input_bound": None,
        "input_low": -6.0,
        "input_high": (12.0, 8.0),
        "input_norm_bound": 11.0,
        "input_half_spaces": (HalfSpace(weights=(1.0, 0.5), bound=8.0),),
        "input_rate_low_per_s": -800.0,
        "input_rate_high_per_s": (3000.0, 1500.0),
    },
}


def limited(design: FilterDesign, name: str) -> FilterDesign:
    """Return a design with other limits."""
    return replace(design, **LIMIT_SETS[name])  # type: ignore[arg-type]  # parts of many types by name


def random_inputs(limits: Limits, count: int, rng: np.random.Generator) -> Array:
    """Return inputs within the limits, shape (count, m), many of them on the boundary."""
    centre, low, high = map(np.array, (limits.centre, limits.low, limits.high))
    wild = rng.normal(size=(count, len(centre))) * limits.reach
    return np.array([limits.nearest(each, centre, low, high) for each in wild])


def directions(limits: Limits, tangents: int) -> tuple[Array, Array]:
    """Return rows G and bounds d of a polygon G u ≥ d around the limits of two axes, tighter the more tangents."""
    rows = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
    bounds = [*limits.low, *(-high for high in limits.high)]
    for half_space in limits.half_spaces:
        rows.append((-half_space.weights[0], -half_space.weights[1]))
        bounds.append(-half_space.bound)
    for norm in limits.norms:
        for angle in np.linspace(0, 2 * np.pi, tangents, endpoint=False) if len(norm.axes) == 2 else (0.0, np.pi):
            row = np.zeros(2)
            row[list(norm.axes)] = (np.cos(angle), np.sin(angle))[: len(norm.axes)]
            rows.append((float(row[0]), float(row[1])))
            bounds.append(-norm.bound)
    return np.array(rows), np.array(bounds)
