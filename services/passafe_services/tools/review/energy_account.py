"""Energy of the tank, recomputed from states and inputs: E ← min(E + ∫h_u dt, E_max), h_u = yᵀu − V̇.

The passivity row lets the power margin fall below what the tank allows by its slack δ alone. So the tank falls below
its reserve by no more than what was granted: E(t) ≥ E_r − ∫δ dt. While no input of the filter is in force, what the
plant's own law takes from the tank counts as granted.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.time_order import MOST_WAITING, TimeOrder
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory


class EnergyAccount(NamedTuple):
    """Extrema of the tank of a run, at samples and between them.

    Attributes:
        tank_min_j: Smallest energy E, J; ``None`` without samples.
        kept_min_j: Smallest E − E_r + ∫δ dt, J; ``None`` where it is not known which slack was in force.
    """

    tank_min_j: Extremum | None
    kept_min_j: Extremum | None


class _Gains(NamedTuple):
    """Samples of a session whose slack is not known yet.

    Attributes:
        plant_ns: Plant times, ns, shape (N,).
        t_s: The same, s.
        runs: Whether an input of the filter is in force, shape (N,).
        level_j: Energy of the tank, J, shape (N,).
        until_s: Time to the next sample, whether in the log or not, s; shape (N,).
        lost_j: What the plant's own law takes from the tank until then, J, shape (N,).
        period_s: Time until the next sample if that is in the log, else 0; shape (N,).
        between_j: Gain at every instant between samples, J, shape (instants, N); NaN without an instant.
    """

    plant_ns: IntArray
    t_s: FloatArray
    runs: NDArray[np.bool_]
    level_j: FloatArray
    until_s: FloatArray
    lost_j: FloatArray
    period_s: FloatArray
    between_j: FloatArray

    def split(self, count: int) -> tuple["_Gains", "_Gains"]:
        return self.cut(slice(count)), self.cut(slice(count, None))

    def cut(self, of: slice) -> "_Gains":
        parts: tuple[Any, ...] = tuple(part[..., of] for part in self)
        return _Gains(*parts)


_LATEST_NS: Final = 2**63 - 1


class EnergyInProgress:
    """Account of the tank of a run that comes piece by piece.

    Args:
        evaluator: Functions of the scenario.
        passivity: The tank.
        points: Instants to evaluate per period, its end included.
        is_exact: Whether the plant is its model; else its own account of the energy counts.
    """

    def __init__(
        self, evaluator: PlantEvaluator, passivity: PassivityConfig, points: int, *, is_exact: bool = True
    ) -> None:
        self._evaluator = evaluator
        self._is_exact = is_exact
        self._passivity = passivity
        self._points = points
        self._level_j: dict[int, float] = {}
        self._tank: Extremum | None = None
        self._kept: Extremum | None = None
        self._granted_j = 0.0
        self._waiting: list[_Gains] = []
        self._order = TimeOrder(1)
        self._slack_ns: IntArray = np.zeros(0, dtype=np.int64)
        self._slack_w: FloatArray = np.zeros(0)
        self._has_decisions = False
        self._begun: set[int] = set()

    def take(self, trajectory: Trajectory, *, has_next: bool) -> None:
        """Take the next samples of a session.

        Args:
            trajectory: Samples; the first of a piece is the last of the piece before.
            has_next: Whether the last sample comes again as the first of another piece.
        """
        session = int(trajectory.session[0])
        gained_j = _gained(trajectory, self._evaluator) if self._is_exact else logged_gain(trajectory)
        first_j = self._level_j.get(session)
        level_j = ledger_from(first_j, gained_j, self._passivity)
        self._level_j[session] = float(level_j[-1])
        self._begun.add(session)
        kept = slice(0, trajectory.samples - 1 if has_next else None)
        self._tank = _lower(self._tank, level_j[kept], trajectory.t_s[kept])
        between_j = self._between(trajectory, level_j)
        gains = _Gains(
            plant_ns=np.rint(trajectory.t_s * NS_PER_S).astype(np.int64),
            t_s=trajectory.t_s,
            runs=trajectory.runs,
            level_j=level_j,
            until_s=np.diff(trajectory.t_s, append=trajectory.t_s[-1:]),
            lost_j=np.append(np.where(trajectory.runs[:-1], 0.0, np.maximum(-gained_j[1:], 0.0)), 0.0),
            period_s=trajectory.period_s,
            between_j=between_j,
        )
        self._waiting.append(gains.cut(kept))
        self._settle()

    def decide(self, at_ns: IntArray, slack_w: FloatArray) -> None:
        """Take slacks of decisions, W, and the plant times, ns, from which they were in force; shape (N,) each."""
        self._has_decisions = self._has_decisions or at_ns.size > 0
        self._extend(*self._order.take(at_ns, slack_w[None]))
        self._settle()

    def result(self) -> EnergyAccount:
        """Return the account; nothing may be taken after it."""
        self._extend(*self._order.finish())
        self._settle(_LATEST_NS)
        is_known = self._has_decisions and len(self._begun) == 1 and not self._order.out_of_order
        return EnergyAccount(self._tank, self._kept if is_known else None)

    def _between(self, trajectory: Trajectory, level_j: FloatArray) -> FloatArray:
        """Return the gains between samples, and lower the smallest energy by them."""
        found = np.full((self._points - 1, trajectory.samples), np.nan)
        for period_s in np.unique(trajectory.period_s[trajectory.period_s > 0]):
            begun = trajectory.period_s == period_s
            x, u, t_s = trajectory.x[:, begun], trajectory.u[:, begun], trajectory.t_s[begun]
            for j in range(1, self._points):
                after_s = float(period_s) * j / self._points
                gain_j = self._evaluator.energy_gain(x, u, after_s)
                found[j - 1, begun] = gain_j
                self._tank = _lower(self._tank, level_j[begun] + gain_j, t_s + after_s)
        return found

    def _extend(self, at_ns: IntArray, slack_w: FloatArray) -> None:
        self._slack_ns = np.concatenate((self._slack_ns, at_ns))
        self._slack_w = np.concatenate((self._slack_w, slack_w[0]))

    def _settle(self, until_ns: int | None = None) -> None:
        """Account for the samples whose slack is known: decisions for later times have come."""
        if until_ns is None:
            until_ns = int(self._slack_ns[-1]) if self._slack_ns.size else -1
        waiting = sum(one.plant_ns.size for one in self._waiting)
        while self._waiting:
            gains = self._waiting[0]
            count = int(np.searchsorted(gains.plant_ns, until_ns, side="left"))
            count = gains.plant_ns.size if until_ns == _LATEST_NS or waiting > MOST_WAITING else count
            settled, left = gains.split(count)
            self._account(settled)
            waiting -= count
            if left.plant_ns.size:
                self._waiting[0] = left
                break
            self._waiting.pop(0)
        if self._slack_ns.size and self._waiting:
            used = max(int(np.searchsorted(self._slack_ns, self._waiting[0].plant_ns[0], side="right")) - 1, 0)
            self._slack_ns, self._slack_w = self._slack_ns[used:], self._slack_w[used:]

    def _account(self, gains: _Gains) -> None:
        if not gains.plant_ns.size:
            return
        newest = np.searchsorted(self._slack_ns, gains.plant_ns, side="right") - 1
        known = newest >= 0
        rates = np.zeros(gains.plant_ns.size)
        rates[known] = self._slack_w[newest[known]]
        more_j = rates * gains.until_s + gains.lost_j
        granted_j = np.cumsum(np.concatenate(([self._granted_j], more_j)))
        self._granted_j = float(granted_j[-1])
        above_j = gains.level_j - self._passivity.tank_reserve_j + granted_j[:-1]
        self._kept = _lower(self._kept, above_j, gains.t_s)
        begun = gains.period_s > 0
        for j in range(1, self._points):
            if not begun.any():
                break
            after_s = gains.period_s[begun] * j / self._points
            gain_j = gains.between_j[j - 1, begun]
            granted = np.where(gains.runs[begun], rates[begun] * after_s, np.maximum(-gain_j, 0.0))
            self._kept = _lower(self._kept, above_j[begun] + gain_j + granted, gains.t_s[begun] + after_s)


def ledger_from(before_j: float | None, gained_j: FloatArray, passivity: PassivityConfig) -> FloatArray:
    """Return the energy of the tank at every sample, J, shape (N,).

    Args:
        before_j: Energy at the first sample; ``None``: a session begins with ``tank_initial_j``.
        gained_j: ∫h_u dt since the sample before, J, shape (N,); the first one is not used.
        passivity: The tank.
    """
    first_j = passivity.tank_initial_j if before_j is None else before_j
    sums = np.cumsum(np.concatenate(([first_j], gained_j[1:])))
    max_j = passivity.tank_max_j
    if (sums[1:] <= max_j).all():
        return sums
    ledger, energy_j = [first_j], first_j
    for gain_j in gained_j[1:].tolist():
        energy_j = min(energy_j + gain_j, max_j)
        ledger.append(energy_j)
    return np.array(ledger, dtype=np.float64)


def tank_ledger(gained_j: FloatArray, session: IntArray, passivity: PassivityConfig) -> FloatArray:
    """Return the energy of the tank at every sample, J, shape (N,); it begins at ``tank_initial_j`` in each session.

    Args:
        gained_j: ∫h_u dt since the sample before, J, shape (N,).
        session: Number of the plant's session, shape (N,).
        passivity: The tank.
    """
    begins = [*np.flatnonzero(np.diff(session, prepend=session[:1] - 1)).tolist(), session.size]
    parts: Sequence[FloatArray] = [ledger_from(None, gained_j[begin:end], passivity) for begin, end in pairwise(begins)]
    return np.concatenate(parts) if parts else np.zeros(0)


def logged_gain(trajectory: Trajectory) -> FloatArray:
    """Return ∫h_u dt since the sample before by the plant's own account, J, shape (N,)."""
    gained: FloatArray = np.diff(trajectory.energy_in_j, prepend=0.0) - np.diff(trajectory.energy_stored_j, prepend=0.0)
    return gained


def _gained(trajectory: Trajectory, evaluator: PlantEvaluator) -> FloatArray:
    """Return ∫h_u dt since the sample before, J; across missing samples, by the plant's own account."""
    gained = logged_gain(trajectory)
    for period_s in np.unique(trajectory.period_s[trajectory.period_s > 0]):
        (begun,) = np.nonzero(trajectory.period_s == period_s)
        gained[begun + 1] = evaluator.energy_gain(trajectory.x[:, begun], trajectory.u[:, begun], float(period_s))
    return gained


def _lower(lowest: Extremum | None, values: FloatArray, t_s: FloatArray) -> Extremum | None:
    if not values.size:
        return lowest
    found = Extremum.lowest(values, t_s)
    return found if lowest is None else min(lowest, found)
