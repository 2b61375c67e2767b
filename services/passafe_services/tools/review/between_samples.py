"""Extrema of barriers, power margin and tank of a run, recomputed from the plant's states, also between samples."""

from dataclasses import dataclass
from sys import float_info
from typing import Any, Final, NamedTuple, Self

import numpy as np

from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.energy_account import EnergyInProgress
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import Decisions
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.trajectory import Trajectory

STATE_ROUNDING: Final = 16 * float_info.epsilon
"""Rounding of a state after one step, relative to its largest number."""


@dataclass(frozen=True, kw_only=True)
class RecomputedMargins:
    """Extrema of a run; ``None`` without data.

    Attributes:
        h_min: Smallest barrier value, at samples and between them.
        h_kept: Smallest barrier value with the error added that it may have by rounding and integration.
        h_possible: Smallest barrier value with the error of the states as read added, too; the true ones have none.
        h_min_barrier: Index of its barrier in the scenario.
        h_min_at_samples: Smallest barrier value at samples only, where the filter acts.
        start_psi: Smallest of ψ₀ … ψ_{r−1} of all barriers where the plant started.
        start_level: Its name.
        power_margin_min: Smallest power margin h_u(x, u), W, at samples and between them.
        power_margin_min_at_samples: Smallest power margin at samples only, W.
        tank_min_j: Smallest energy of the tank, J, at samples and between them.
        energy_kept_j: Smallest E − E_r + ∫δ dt, J; see ``EnergyAccount``.
        u_norm_max: Largest ‖u‖₂ in force.
        mismatch_max: Largest ``Trajectory.mismatch``.
    """

    h_min: Extremum | None = None
    h_kept: Extremum | None = None
    h_possible: Extremum | None = None
    h_min_barrier: int | None = None
    h_min_at_samples: Extremum | None = None
    start_psi: Extremum | None = None
    start_level: str | None = None
    power_margin_min: Extremum | None = None
    power_margin_min_at_samples: Extremum | None = None
    tank_min_j: Extremum | None = None
    energy_kept_j: Extremum | None = None
    u_norm_max: Extremum | None = None
    mismatch_max: Extremum | None = None

    @classmethod
    def of(
        cls,
        trajectory: Trajectory,
        evaluator: PlantEvaluator,
        passivity: PassivityConfig,
        points: int,
        decisions: Decisions | None = None,
        *,
        is_exact: bool = True,
    ) -> Self:
        """Recompute the extrema.

        Args:
            trajectory: Motion of the plant.
            evaluator: Functions of the scenario.
            passivity: The tank.
            points: Instants to evaluate per period, its end included.
            decisions: Decisions of the filter, for the slack that they granted; nothing else is taken from them.
            is_exact: Whether the plant is its model.
        """
        margins = MarginsInProgress(evaluator, passivity, points, is_exact=is_exact)
        for session in trajectory.sessions():
            margins.take(session, is_start=True, has_next=False)
        if decisions is not None:
            margins.energy.decide(decisions.at_ns, decisions.slack_w)
        return cls(**margins.extrema())


class MarginsInProgress:
    """Extrema of a run that comes piece by piece.

    Args:
        evaluator: Functions of the scenario.
        passivity: The tank.
        points: Instants to evaluate per period, its end included.
        is_exact: Whether the plant is its model.
        reading_error: Largest error of each state as it is read, state units, shape (n,); none if not given.

    Attributes:
        energy: Account of the tank, which takes the slacks of the decisions.
    """

    def __init__(
        self,
        evaluator: PlantEvaluator,
        passivity: PassivityConfig,
        points: int,
        *,
        is_exact: bool = True,
        reading_error: FloatArray | None = None,
    ) -> None:
        self.energy = EnergyInProgress(evaluator, passivity, points, is_exact=is_exact)
        self._evaluator = evaluator
        self._points = points
        self._reading_error = 0.0 if reading_error is None else reading_error.reshape(-1, 1)
        self._longest_s = 0.0
        self._lowest: _Lowest | None = None
        self._at_samples: _Lowest | None = None
        self._found: dict[str, Extremum] = {}
        self._level: str | None = None

    def take(self, trajectory: Trajectory, *, is_start: bool, has_next: bool, is_read: bool = False) -> None:
        """Take the next samples of a session, at least one.

        Args:
            trajectory: Samples of one session; the first of a piece is the last of the piece before.
            is_start: Whether the session begins with them.
            has_next: Whether the last sample comes again as the first of another piece.
            is_read: Whether the states are as they were read, rather than the true ones.
        """
        reading_error = self._reading_error if is_read else 0.0
        evaluator, kept = self._evaluator, slice(0, trajectory.samples - 1 if has_next else None)
        t_s, x, u = trajectory.t_s[kept], trajectory.x[:, kept], trajectory.u[:, kept]
        # A state of 1e200 overflows in x²; the extremum shows it, so a warning is redundant.
        with np.errstate(over="ignore", invalid="ignore"):
            if is_start:
                self._take_start(trajectory)
            if t_s.size:
                self._longest_s = max(self._longest_s, float(trajectory.period_s.max()))
                error = _state_error(evaluator, x, u, self._longest_s)
                found = _Lowest.of(evaluator, x, t_s, error, reading_error)
                self._at_samples = _lower(self._at_samples, found)
                power = Extremum.lowest(evaluator.power_margin(x, u), t_s)
                self._lower("power_margin_min_at_samples", power)
                self._lower("power_margin_min", power)
                self._higher("u_norm_max", Extremum.highest(np.linalg.norm(u, axis=0), t_s))
            between, power_between = _between(trajectory, evaluator, self._points, reading_error)
            self._lowest = _lower(_lower(self._lowest, self._at_samples), between)
            if power_between is not None:
                self._lower("power_margin_min", power_between)
            self.energy.take(trajectory, has_next=has_next)
            mismatch, mismatch_t_s = trajectory.mismatch(evaluator)
            if mismatch.size:
                self._higher("mismatch_max", Extremum.highest(mismatch, mismatch_t_s))

    def extrema(self) -> dict[str, Any]:
        """Return the extrema by the names of ``RecomputedMargins``."""
        energy, lowest = self.energy.result(), self._lowest
        return {
            "h_min": None if lowest is None else lowest.h,
            "h_kept": None if lowest is None else lowest.kept,
            "h_possible": None if lowest is None else lowest.possible,
            "h_min_barrier": None if lowest is None else lowest.barrier,
            "h_min_at_samples": None if self._at_samples is None else self._at_samples.h,
            "start_level": self._level,
            "tank_min_j": energy.tank_min_j,
            "energy_kept_j": energy.kept_min_j,
            **self._found,
        }

    def _take_start(self, trajectory: Trajectory) -> None:
        start, level = _start(trajectory, self._evaluator)
        before = self._found.get("start_psi")
        if start is not None and (before is None or start < before):
            self._found["start_psi"], self._level = start, level

    def _lower(self, name: str, extremum: Extremum) -> None:
        self._found[name] = _smaller(self._found.get(name), extremum)

    def _higher(self, name: str, extremum: Extremum) -> None:
        before = self._found.get(name)
        if before is None or (-extremum.value, extremum.at_s) < (-before.value, before.at_s):
            self._found[name] = extremum


def _start(trajectory: Trajectory, evaluator: PlantEvaluator) -> tuple[Extremum | None, str | None]:
    """Return the smallest value that has to be positive where a session of the plant starts, and its name."""
    if not evaluator.protected:
        return None, None
    t_s = trajectory.t_s[:1]
    lowest = [Extremum.lowest(values, t_s) for values in evaluator.psi(trajectory.x[:, :1], t_s)]
    where = min(range(len(lowest)), key=lowest.__getitem__)
    return lowest[where], evaluator.protected[where]


class _Lowest(NamedTuple):
    """Smallest value of several barriers, the index of its barrier, and the smallest with errors added."""

    h: Extremum
    barrier: int
    kept: Extremum
    possible: Extremum

    @classmethod
    def of(
        cls,
        evaluator: PlantEvaluator,
        x: FloatArray,
        t_s: FloatArray,
        error: FloatArray,
        reading_error: FloatArray | float,
    ) -> "_Lowest | None":
        """Return the smallest of h at states, shape (n, N); ``None`` without barriers.

        Args:
            evaluator: Functions of the scenario.
            x: The states.
            t_s: Plant times, s, shape (N,).
            error: By how much each number of a state may be wrong by computation, shape (N,).
            reading_error: By how much it may be wrong by how it was read, shape (n, 1); 0: by nothing.
        """
        h = evaluator.h(x, t_s)
        if not h.shape[0]:
            return None
        lowest = [Extremum.lowest(values, t_s) for values in h]
        barrier = min(range(len(lowest)), key=lowest.__getitem__)
        kept = possible = min(Extremum.lowest(values, t_s) for values in h + evaluator.h_error(x, t_s, error))
        if np.any(reading_error):
            errors = evaluator.h_error(x, t_s, error + reading_error)
            possible = min(Extremum.lowest(values, t_s) for values in h + errors)
        return cls(lowest[barrier], barrier, kept, possible)

    def and_lower(self, other: "_Lowest") -> "_Lowest":
        """Return the smallest of both."""
        lower = min(self, other)
        return lower._replace(kept=min(self.kept, other.kept), possible=min(self.possible, other.possible))


def _state_error(evaluator: PlantEvaluator, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
    """Return by how much a state after a step may be wrong, shape (N,): integration, and rounding of its sums."""
    error: FloatArray = evaluator.flow_error(x, u, duration_s) + STATE_ROUNDING * np.abs(x).max(axis=0)
    return error


def _between(
    trajectory: Trajectory, evaluator: PlantEvaluator, points: int, reading_error: FloatArray | float
) -> tuple[_Lowest | None, Extremum | None]:
    """Return the lowest barrier value and the lowest power margin between samples."""
    lowest: _Lowest | None = None
    power_min: Extremum | None = None
    for instants in trajectory.between(evaluator, points):
        error = _state_error(evaluator, instants.x, instants.u, instants.after_s)
        found = _Lowest.of(evaluator, instants.x, instants.t_s, error, reading_error)
        lowest = _lower(lowest, found)
        margin = evaluator.power_margin(instants.x, instants.u)
        power_min = _smaller(power_min, Extremum.lowest(margin, instants.t_s))
    return lowest, power_min


def _lower(a: _Lowest | None, b: _Lowest | None) -> _Lowest | None:
    if a is None or b is None:
        return a or b
    return a.and_lower(b)


def _smaller(a: Extremum | None, b: Extremum) -> Extremum:
    return b if a is None else min(a, b)
