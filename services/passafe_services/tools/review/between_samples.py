"""Extrema of barriers, power margin and tank of a run, recomputed from the plant's states, also between samples."""

from dataclasses import dataclass
from sys import float_info
from typing import Final, NamedTuple, Self

import numpy as np

from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.energy_account import account_of
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
        h_kept: Smallest barrier value with the error added that it may have.
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
    ) -> Self:
        """Recompute the extrema.

        Args:
            trajectory: Motion of the plant.
            evaluator: Functions of the scenario.
            passivity: The tank.
            points: Instants to evaluate per period, its end included.
            decisions: Decisions of the filter, for the slack that they granted; nothing else is taken from them.
        """
        if trajectory.samples == 0:
            return cls()
        t_s, x, u = trajectory.t_s, trajectory.x, trajectory.u
        # A state of 1e200 overflows in x²; the extremum shows it, so a warning is redundant.
        with np.errstate(over="ignore", invalid="ignore"):
            error = _state_error(evaluator, x, u, float(trajectory.period_s.max()))
            at_samples = _Lowest.of(evaluator.h(x, t_s), evaluator.h_error(x, t_s, error), t_s)
            power = Extremum.lowest(evaluator.power_margin(x, u), t_s)
            lowest, power_between = _between(trajectory, evaluator, points, at_samples)
            start, level = _start(trajectory, evaluator)
            energy = account_of(trajectory, evaluator, passivity, points, decisions)
            mismatch, mismatch_t_s = trajectory.mismatch(evaluator)
            norms = np.linalg.norm(u, axis=0)
        return cls(
            h_min=None if lowest is None else lowest.h,
            h_kept=None if lowest is None else lowest.kept,
            h_min_barrier=None if lowest is None else lowest.barrier,
            h_min_at_samples=None if at_samples is None else at_samples.h,
            start_psi=start,
            start_level=level,
            power_margin_min=_smaller(power_between, power),
            power_margin_min_at_samples=power,
            tank_min_j=energy.tank_min_j,
            energy_kept_j=energy.kept_min_j,
            u_norm_max=Extremum.highest(norms, t_s),
            mismatch_max=Extremum.highest(mismatch, mismatch_t_s) if mismatch.size else None,
        )


def _start(trajectory: Trajectory, evaluator: PlantEvaluator) -> tuple[Extremum | None, str | None]:
    """Return the smallest value that has to be positive where a session of the plant starts, and its name."""
    if not evaluator.protected:
        return None, None
    starts = np.diff(trajectory.session, prepend=-1) != 0
    t_s = trajectory.t_s[starts]
    lowest = [Extremum.lowest(values, t_s) for values in evaluator.psi(trajectory.x[:, starts], t_s)]
    where = min(range(len(lowest)), key=lowest.__getitem__)
    return lowest[where], evaluator.protected[where]


class _Lowest(NamedTuple):
    """Smallest value of several barriers, the index of its barrier, and the smallest with its error added."""

    h: Extremum
    barrier: int
    kept: Extremum

    @classmethod
    def of(cls, h: FloatArray, error: FloatArray, t_s: FloatArray) -> "_Lowest | None":
        """Return the smallest of h with errors, each of shape (barriers, N); ``None`` without barriers."""
        if not h.shape[0]:
            return None
        lowest = [Extremum.lowest(values, t_s) for values in h]
        barrier = min(range(len(lowest)), key=lowest.__getitem__)
        return cls(lowest[barrier], barrier, min(Extremum.lowest(values, t_s) for values in h + error))

    def and_lower(self, other: "_Lowest") -> "_Lowest":
        """Return the smallest of both."""
        lower = min(self, other)
        return lower._replace(kept=min(self.kept, other.kept))


def _state_error(evaluator: PlantEvaluator, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
    """Return by how much a state after a step may be wrong, shape (N,): integration, and rounding of its sums."""
    error: FloatArray = evaluator.flow_error(x, u, duration_s) + STATE_ROUNDING * np.abs(x).max(axis=0)
    return error


def _between(
    trajectory: Trajectory, evaluator: PlantEvaluator, points: int, lowest: _Lowest | None
) -> tuple[_Lowest | None, Extremum | None]:
    """Return the lowest barrier value, that at samples included, and the lowest power margin between samples."""
    power_min: Extremum | None = None
    for instants in trajectory.between(evaluator, points):
        error = _state_error(evaluator, instants.x, instants.u, instants.after_s)
        h = evaluator.h(instants.x, instants.t_s)
        found = _Lowest.of(h, evaluator.h_error(instants.x, instants.t_s, error), instants.t_s)
        if lowest is not None and found is not None:
            lowest = lowest.and_lower(found)
        margin = evaluator.power_margin(instants.x, instants.u)
        power_min = _smaller(power_min, Extremum.lowest(margin, instants.t_s))
    return lowest, power_min


def _smaller(a: Extremum | None, b: Extremum) -> Extremum:
    return b if a is None else min(a, b)
