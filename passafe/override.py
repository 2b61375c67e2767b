"""What the filter changed in one decision, by which rows, and how much of the command would have passed unchanged.

Asked for is u_want = u + dt·φ, or û where there was no input before. The decision is

    u⁺ − u_want = Σᵢ λᵢ gᵢ,

the multipliers' stationarity: every row that binds pushes by λᵢ along its gradient of unit length, and a limit of an
axis pushes by what it cuts off u_want, too. u_want moves with the operator's part by k = dt·k_i (1 at the start), so
(u⁺ − u_want)/k is by how much the command would have had to differ for the same input to pass without any change.
"""

from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import Final

import numpy as np

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.workspace import Array

ACTIVE_DUAL: Final = 1e-6
"""Push from which a row counts as active, units of u."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Cause:
    """A row that pushed.

    Attributes:
        row: Its name.
        push: λ, units of u; for a limit of an axis with what it cut off what was asked for.
        share: Share of the change, λ gᵀ(u⁺ − u_want)/‖u⁺ − u_want‖². The shares of all rows sum to 1; one is negative
            where the others push against it.
    """

    row: str
    push: float
    share: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Override:
    """What became of a request.

    Attributes:
        change: u⁺ − u_want, shape (m,), units of u.
        held_back: The same in terms of the operator's command, (u⁺ − u_want)/k, shape (m,), units of u. Where the
            input has settled it is u⁺ − û.
        causes: Active rows, the one with the largest share first; none under the fail-safe law.
        allowed_fraction: Largest s in [0, 1] for which the command s·(u_h, u̇_h) would have passed without a change: no
            row relaxed, no slack, no limit in the way. 0 where no s would have.
        unavoidable: Whether no s in [0, 1] would have.
    """

    change: Array
    held_back: Array
    causes: tuple[Cause, ...]
    allowed_fraction: float
    unavoidable: bool

    @property
    def size(self) -> float:
        """‖held_back‖, units of u."""
        return float(np.linalg.norm(self.held_back))


class Explainer:
    """Explains the decisions of one filter.

    Rows count as they are in the decision: with its tangents, where they are not affine in u, and with its margins
    between samples, which are made for inputs near u⁺. They are kept where they are missed by no more than the
    certificate tolerates.
    """

    def __init__(self, core: SafetyPassivityFilter) -> None:
        """Take from the filter what does not change."""
        design = core.design
        self._names, self._duties, self._m = core.row_names, core.duties, design.system.m
        self._dt_s, self._k_i = design.dt_s, design.k_i
        self._norm = design.limits.norm
        self._tolerance = design.tolerance.residual

    def override(self, decision: Decision) -> Override:
        """Return what became of the decision's request."""
        with np.errstate(all="ignore"):  # what is no number stays none; nothing is decided from it here
            start = bool(decision.part("start")[0])
            wanted = decision.part("u_nominal") if start else decision.part("u") + self._dt_s * decision.phi
            change = decision.part("u_plus") - wanted
            if decision.status is Status.PASSED and not change.any():
                return Override(change=change, held_back=change, causes=(), allowed_fraction=1.0, unavoidable=False)
            gain = 1.0 if start else self._dt_s * self._k_i
            command = decision.part("u_h") if start else gain * decision.part("u_h")
            if not start:
                command = command + self._dt_s * decision.part("u_h_rate")
            fraction = self._allowed_fraction(decision, wanted, command)
            return Override(
                change=change,
                held_back=change / gain,
                causes=self._causes(decision, wanted, change),
                allowed_fraction=0.0 if fraction is None else fraction,
                unavoidable=fraction is None,
            )

    def _causes(self, decision: Decision, wanted: Array, change: Array) -> tuple[Cause, ...]:
        """Return the active rows in the order of their shares."""
        m, duties = self._m, self._duties
        cut_off = decision.part("u_ref") - wanted
        push = decision.duals.copy()
        push[duties : duties + 2 * m] += np.maximum(np.concatenate((cut_off, -cut_off)), 0.0)
        along = np.concatenate((self._rows(decision)[:, :m] @ change, change, -change))
        if self._norm is not None:
            along = np.concatenate((along, -decision.part("cuts").reshape((-1, m), order="F") @ change))
        square = float(change @ change)
        causes = [
            Cause(row=self._names[i], push=float(push[i]), share=float(push[i] * along[i]) / square if square else 0.0)
            for i in np.flatnonzero(push > ACTIVE_DUAL)
        ]
        return tuple(sorted(causes, key=lambda cause: -cause.share))

    def _allowed_fraction(self, decision: Decision, wanted: Array, command: Array) -> float | None:
        """Return the largest s with every row and limit kept at u_want − (1 − s)·command; ``None`` if there is none."""
        m, tolerance = self._m, self._tolerance
        if not isfinite(float(wanted @ wanted + command @ command)):
            return None
        G = self._rows(decision)[:, :m]
        kept = np.concatenate(
            (
                G @ (wanted - decision.part("u_ref")) - decision.part("d"),
                wanted - decision.part("low"),
                decision.part("high") - wanted,
            )
        )
        slope = np.concatenate((G @ command, command, -command))
        least, most = _interval((kept + tolerance).tolist(), slope.tolist())
        if self._norm is not None:
            at_least, at_most = _within(wanted, command, self._norm + tolerance)
            least, most = max(least, at_least), min(most, at_most)
        return 1.0 - least if least <= min(most, 1.0) else None

    def _rows(self, decision: Decision) -> Array:
        return decision.part("G").reshape((self._duties, -1), order="F") if self._duties else np.zeros((0, self._m))


def _interval(kept: list[float], slope: list[float]) -> tuple[float, float]:
    """Return the least and the largest q ≥ 0 with kept − q·slope ≥ 0 in every place; the least is inf without one."""
    least, most = 0.0, inf
    for value, falls in zip(kept, slope, strict=True):
        if falls > 0.0:
            most = min(most, value / falls)
        elif value < 0.0 and falls < 0.0:
            least = max(least, value / falls)
        elif not value >= 0.0:
            return inf, most
    return least, most


def _within(wanted: Array, command: Array, norm: float) -> tuple[float, float]:
    """Return the least and the largest q with ‖wanted − q·command‖ ≤ norm; inf and −inf without one."""
    a, b, c = float(command @ command), float(command @ wanted), float(wanted @ wanted) - norm**2
    if a == 0.0:
        return (-inf, inf) if c <= 0.0 else (inf, -inf)
    under = b * b - a * c
    if not under >= 0.0:
        return inf, -inf
    return (b - sqrt(under)) / a, (b + sqrt(under)) / a
