"""Feasibility of the filter's rows at given states: protected set, hard rows, and hard rows with passivity."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from passafe.design import FilterDesign
from passafe.numerics.workspace import Array
from passafe_services.tools.feasibility.batch_rows import BatchRows, Kept
from passafe_services.tools.feasibility.largest_margin import largest_margin_inputs

AT_ONCE: Final = 1000
"""States whose linear programs are solved together."""

ROUNDS: Final = 6
"""Largest number of re-linearizations at the best input."""

SETTLED: Final = 1e-6
"""Gain of margin below which the search ends, relative to 1 + |margin|."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Findings:
    """Findings at each of C states; every margin is evaluated at an input that was found.

    Attributes:
        states: Shape (n, C).
        h: Smallest h.
        protecting: Smallest of ψ₀ … ψ_{r−1}: the rows protect the set in which it is not negative.
        hard_margin: Largest margin of an input within the limits for all hard rows, units of u; negative: violation.
        passive_margin: Largest margin for the hard rows and the passivity row without slack, units of u.
        tolerance: Tolerance of a row, units of u.
        unsettled: Whether the search ended before it converged.
    """

    states: Array
    h: Array
    protecting: Array
    hard_margin: Array
    passive_margin: Array
    tolerance: float
    unsettled: Kept

    @property
    def inside(self) -> Kept:
        """True for states in the set that the rows protect."""
        return self.protecting >= 0

    @property
    def hard_kept(self) -> Kept:
        """True for states where an input within the limits satisfies the hard rows."""
        return self.hard_margin >= -self.tolerance

    @property
    def passive_kept(self) -> Kept:
        """True for states where an input within the limits satisfies the hard rows and passivity."""
        return self.passive_margin >= -self.tolerance

    @classmethod
    def joined(cls, parts: list["Findings"]) -> "Findings":
        """Concatenate the findings of several sets of states, at least one."""
        first, *_ = parts
        names = ("h", "protecting", "hard_margin", "passive_margin", "unsettled")
        merged = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        states = np.concatenate([part.states for part in parts], axis=1)
        return cls(states=states, tolerance=first.tolerance, **merged)


class ConstraintFeasibility:
    """Evaluates feasibility for the filter of one design."""

    def __init__(self, design: FilterDesign, t_s: float = 0.0) -> None:
        """Derive the rows; see ``BatchRows``."""
        self._many = BatchRows(design, t_s)

    def piecewise(self, states: Array) -> Iterator[Findings]:
        """Yield the findings of chunks of ``AT_ONCE`` states.

        Args:
            states: Shape (n, C).
        """
        for begin in range(0, states.shape[1], AT_ONCE):
            yield self.at(states[:, begin : begin + AT_ONCE])

    def at(self, states: Array) -> Findings:
        """Return the findings.

        Args:
            states: Shape (n, C).
        """
        h, protecting = self._many.barriers(states)
        passive_margin, passive_unsettled = self._largest_margin(states, passive=True)
        hard_margin, hard_unsettled = self._largest_margin(states, passive=False)
        return Findings(
            states=states,
            h=h,
            protecting=protecting,
            hard_margin=np.maximum(hard_margin, passive_margin),  # an input for all rows also satisfies the hard ones
            passive_margin=passive_margin,
            tolerance=self._many.tolerance,
            unsettled=passive_unsettled | hard_unsettled,
        )

    def _largest_margin(self, states: Array, *, passive: bool) -> tuple[Array, Kept]:
        """Return the largest margin found, shape (C,), and whether the search ended before it converged.

        ε and tangents are valid in a neighbourhood of u_lin: first the whole box of inputs, then the smallest
        neighbourhood that the filter uses, around the best input so far. Each input is evaluated with the rows of its
        own neighbourhood, whatever margin its linear program claimed.
        """
        many = self._many
        count, m = states.shape[1], len(many.limits.magnitude)
        whole = many.rows(states, np.zeros((count, m)), np.tile(many.limits.magnitude, (count, 1)), passive=passive)
        u, _ = largest_margin_inputs(whole, many.limits)
        best, best_u = np.full(count, -np.inf), u.copy()
        left = np.arange(count)
        for _ in range(ROUNDS):
            here = states[:, left]
            nearby = np.tile(many.least_trust, (len(left), 1))
            found = many.rows(here, u[left], nearby, passive=passive).margin(u[left])
            better = left[found > best[left]]
            best[better], best_u[better] = found[found > best[left]], u[better]
            rows = many.rows(here, best_u[left], nearby, passive=passive)
            u[left], claimed = largest_margin_inputs(rows, many.limits)
            so_far = best[left]
            more = claimed > so_far + SETTLED * (1 + np.abs(so_far, where=np.isfinite(so_far), out=np.zeros(len(left))))
            left = left[more]
            if not len(left):
                break
        unsettled = np.zeros(count, dtype=np.bool_)
        unsettled[left] = True
        return best, unsettled
