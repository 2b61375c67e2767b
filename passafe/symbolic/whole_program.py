"""The rows of the whole program: constraints, then limits of every axis, half-spaces, tangents of the norms."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.decision_schema import Program
from passafe.limits import Limits
from passafe.symbolic.rows import ConstraintRow

TANGENTS_PER_AXIS: Final = 6
"""Tangents by which a limit of the norm is replaced, at most, for each axis."""

NORM_TOLERANCE: Final = 1e-7
"""Length beyond the one asked for, relative to the norm's limit; the length asked for is less by as much."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RowLayout:
    """Numbers and names of the whole program's rows.

    Attributes:
        names: Of all N rows: constraints (barriers in the order of the design, then passivity), the least and then the
            largest input of every axis, half-spaces, tangents of one norm after the other.
        constraints: Number of constraints.
        hard: Number of hard ones among them; they come first.
        tangents: Number of tangents.
        columns: k, length of z: m, and one more if a row is soft.
    """

    names: tuple[str, ...]
    constraints: int
    hard: int
    tangents: int
    columns: int

    @classmethod
    def of(cls, rows: Sequence[ConstraintRow], limits: Limits) -> "RowLayout":
        """Return the layout for some constraints and limits."""
        m = len(limits.low)
        tangents = sum(tangents_of(norm) for norm in limits.norms)
        hard = sum(row.slack_price is None for row in rows)
        return cls(
            names=(
                *(row.name for row in rows),
                *(f"input {i} low" for i in range(m)),
                *(f"input {i} high" for i in range(m)),
                *(f"half-space {j}" for j in range(len(limits.half_spaces))),
                *(f"norm {j}" for j in range(tangents)),
            ),
            constraints=len(rows),
            hard=hard,
            tangents=tangents,
            columns=m + (hard < len(rows)),
        )


def tangents_of(norm: NormBound) -> int:
    """Return the number of tangents by which a norm's limit is replaced at most."""
    return TANGENTS_PER_AXIS * len(norm.axes)


def norm_asked(norm: NormBound) -> float:
    """Return the length that answers are asked to have at most over the norm's axes, units of u.

    A little less than the limit, so that no accepted answer needs shortening: a shortened one would not be the nearest.
    """
    return norm.bound * (1 - NORM_TOLERANCE)


def half_space_asked(half_space: HalfSpace, limits: Limits) -> float:
    """Return the bound that answers are asked to keep, units of u: less than the limit for the same reason."""
    return half_space.bound - NORM_TOLERANCE * limits.reach


def shape_tolerance(limits: Limits) -> float:
    """Return the overreach up to which an answer keeps balls and half-spaces, units of u; 0 where there are none."""
    return NORM_TOLERANCE * _scale(limits)


def overreach(limits: Limits, u: ca.SX) -> ca.SX:
    """Return by how much an input is beyond what is asked of balls and half-spaces, scalar; 0 where there are none.

    Units of u for a single ball; others are scaled so that ``shape_tolerance`` is the tolerance of each.
    """
    beyond = []
    for norm in limits.norms:
        length = ca.norm_2(u[list(norm.axes)]) - norm_asked(norm)
        beyond.append(length if norm.bound == _scale(limits) else length * (_scale(limits) / norm.bound))
    for half_space in limits.half_spaces:
        missed = ca.dot(ca.DM(list(half_space.weights)), u) - half_space_asked(half_space, limits)
        beyond.append(missed * (_scale(limits) / limits.reach))
    return ca.mmax(ca.vertcat(*beyond)) if beyond else ca.SX(0)


def first_cuts(limits: Limits) -> ca.SX:
    """Return tangents at the end of their norm's first axis, shape (tangents, m): ‖u‖ ≤ B implies u₁ ≤ B."""
    m = len(limits.low)
    cuts = [ca.repmat(ca.SX.eye(m)[norm.axes[0], :], tangents_of(norm), 1) for norm in limits.norms]
    return ca.densify(ca.vertcat(ca.SX(0, m), *cuts))


def limit_bounds(limits: Limits) -> tuple[ca.DM, ca.DM, ca.DM]:
    """Return the half-spaces' weights, shape (P, m), their bounds as asked and the tangents' as asked, columns."""
    m = len(limits.low)
    weights = ca.DM(np.array([half_space.weights for half_space in limits.half_spaces]).reshape(-1, m))
    bounds = ca.DM([half_space_asked(half_space, limits) for half_space in limits.half_spaces])
    tangents = ca.DM([norm_asked(norm) for norm in limits.norms for _ in range(tangents_of(norm))])
    return weights, bounds, tangents


def whole_rows(program: Program[ca.SX], cuts: ca.SX, limits: Limits) -> tuple[ca.SX, ca.SX]:
    """Return G and d of the whole program, shapes (N, k) and (N, 1).

    Args:
        program: Its constraints and limits.
        cuts: Directions of the norms' tangents, shape (tangents, m).
        limits: The filter's.
    """
    m, k = program.u_ref.numel(), program.G.shape[1]
    axes = ca.horzcat(ca.SX.eye(m), ca.SX(m, k - m))
    weights, bounds, lengths = limit_bounds(limits)
    planes, tangents = (ca.horzcat(-rows, ca.SX(rows.shape[0], k - m)) for rows in (ca.SX(weights), cuts))
    return (
        ca.vertcat(program.G, axes, -axes, planes, tangents),
        ca.vertcat(
            program.d,
            program.low - program.u_ref,
            program.u_ref - program.high,
            weights @ program.u_ref - bounds,
            cuts @ program.u_ref - lengths,
        ),
    )


def _scale(limits: Limits) -> float:
    """Return what tolerances of balls and half-spaces are relative to, units of u."""
    if limits.norms:
        return max(norm.bound for norm in limits.norms)
    return limits.reach if limits.half_spaces else 0.0
