"""The rows of the whole program: constraints, then limits of every axis, then tangents of the norm's limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca

from passafe.decision_schema import Program
from passafe.limits import Limits
from passafe.rows import ConstraintRow

TANGENTS_PER_AXIS: Final = 6
"""Tangents by which a limit of the norm is replaced, at most, for each axis."""

NORM_TOLERANCE: Final = 1e-7
"""Length beyond the one asked for, relative to the norm's limit; the length asked for is less by as much."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RowLayout:
    """Numbers and names of the whole program's rows.

    Attributes:
        names: Of all N rows: constraints (barriers in the order of the design, then passivity), the least and then the
            largest input of every axis, tangents of the norm.
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
        m = len(limits.magnitude)
        tangents = 0 if limits.norm is None else TANGENTS_PER_AXIS * m
        hard = sum(row.slack_price is None for row in rows)
        return cls(
            names=(
                *(row.name for row in rows),
                *(f"input {i} low" for i in range(m)),
                *(f"input {i} high" for i in range(m)),
                *(f"norm {j}" for j in range(tangents)),
            ),
            constraints=len(rows),
            hard=hard,
            tangents=tangents,
            columns=m + (hard < len(rows)),
        )


def norm_asked(limits: Limits) -> float:
    """Return the length that answers are asked to have at most, units of u; 0 without a limit.

    A little less than the limit, so that no accepted answer needs shortening: a shortened one would not be the nearest.
    """
    return (limits.norm or 0.0) * (1 - NORM_TOLERANCE)


def first_cuts(tangents: int, m: int) -> ca.SX:
    """Return tangents that all cut off the end of the first axis, shape (tangents, m): ‖u‖ ≤ B implies u₁ ≤ B."""
    return ca.horzcat(ca.SX.ones(tangents, 1), ca.SX.zeros(tangents, m - 1))


def whole_rows(program: Program[ca.SX], cuts: ca.SX, norm: float) -> tuple[ca.SX, ca.SX]:
    """Return G and d of the whole program, shapes (N, k) and (N, 1).

    Args:
        program: Its constraints and limits.
        cuts: Directions of the norm's tangents, shape (tangents, m).
        norm: Length that tangents allow, units of u.
    """
    m, k = program.u_ref.numel(), program.G.shape[1]
    axes = ca.horzcat(ca.SX.eye(m), ca.SX(m, k - m))
    tangents = ca.horzcat(-cuts, ca.SX(cuts.shape[0], k - m))
    return (
        ca.vertcat(program.G, axes, -axes, tangents),
        ca.vertcat(program.d, program.low - program.u_ref, program.u_ref - program.high, cuts @ program.u_ref - norm),
    )
