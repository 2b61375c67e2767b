"""Extrema of barriers, power margin and tank of a run, recomputed from the plant's states, also between samples."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.trajectory import Trajectory


class Extremum(NamedTuple):
    """Extreme value and the plant time, s, at which it occurred."""

    value: float
    at_s: float

    @classmethod
    def lowest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """Return the smallest of at least one value; a NaN counts as −∞."""
        known = np.where(np.isnan(values), -np.inf, values)
        where = int(np.argmin(known))
        return cls(float(known[where]), float(t_s[where]))

    @classmethod
    def highest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """Return the largest of at least one value; a NaN counts as +∞."""
        lowest = cls.lowest(-values, t_s)
        return cls(-lowest.value, lowest.at_s)


@dataclass(frozen=True, kw_only=True)
class RecomputedMargins:
    """Extrema of a run; ``None`` without data.

    Attributes:
        h_min: Smallest barrier value, at samples and between them.
        h_min_barrier: Index of its barrier in the scenario.
        h_min_at_samples: Smallest barrier value at samples only, where the filter acts.
        power_margin_min: Smallest power margin h_u(x, u), W, at samples and between them.
        power_margin_min_at_samples: Smallest power margin at samples only, W.
        tank_min_j: Smallest energy of the tank, J, at samples.
        u_norm_max: Largest ‖u‖₂ in force.
        mismatch_max: Largest ``Trajectory.mismatch``.
    """

    h_min: Extremum | None = None
    h_min_barrier: int | None = None
    h_min_at_samples: Extremum | None = None
    power_margin_min: Extremum | None = None
    power_margin_min_at_samples: Extremum | None = None
    tank_min_j: Extremum | None = None
    u_norm_max: Extremum | None = None
    mismatch_max: Extremum | None = None

    @classmethod
    def of(cls, trajectory: Trajectory, evaluator: PlantEvaluator, passivity: PassivityConfig, points: int) -> Self:
        """Recompute the extrema, with ``points`` instants per period between samples."""
        if trajectory.samples == 0:
            return cls()
        t_s, x, u = trajectory.t_s, trajectory.x, trajectory.u
        # A state of 1e200 overflows in x²; the extremum shows it, so a warning is redundant.
        with np.errstate(over="ignore", invalid="ignore"):
            at_samples = _Lowest.of(evaluator.h(x, t_s), t_s)
            power = Extremum.lowest(evaluator.power_margin(x, u), t_s)
            lowest, power_between = _between(trajectory, evaluator, points, at_samples)
            mismatch, mismatch_t_s = trajectory.mismatch(evaluator)
            norms = np.linalg.norm(u, axis=0)
        return cls(
            h_min=None if lowest is None else lowest.h,
            h_min_barrier=None if lowest is None else lowest.barrier,
            h_min_at_samples=None if at_samples is None else at_samples.h,
            power_margin_min=_smaller(power_between, power),
            power_margin_min_at_samples=power,
            tank_min_j=Extremum.lowest(tank_ledger(trajectory, passivity), t_s),
            u_norm_max=Extremum.highest(norms, t_s),
            mismatch_max=Extremum.highest(mismatch, mismatch_t_s) if mismatch.size else None,
        )


def tank_ledger(trajectory: Trajectory, passivity: PassivityConfig) -> FloatArray:
    """Return the energy of the tank at every sample, J, from the plant's measured energies.

    E ← min(E + ∫yᵀu − ΔV, E_max) from one sample to the next, starting at ``tank_initial_j``. Across missing messages
    the sum is added at once.
    """
    gained = np.diff(trajectory.energy_in_j, prepend=0.0) - np.diff(trajectory.energy_stored_j, prepend=0.0)
    ledger: list[float] = []
    session: int | None = None
    energy_j, initial_j, max_j = 0.0, passivity.tank_initial_j, passivity.tank_max_j
    for gain_j, its_session in zip(gained.tolist(), trajectory.session.tolist(), strict=True):
        if its_session != session:
            session, energy_j = its_session, initial_j
        else:
            energy_j = min(energy_j + gain_j, max_j)
        ledger.append(energy_j)
    return np.array(ledger, dtype=np.float64)


class _Lowest(NamedTuple):
    """Smallest value of several barriers and the index of its barrier."""

    h: Extremum
    barrier: int

    @classmethod
    def of(cls, h: FloatArray, t_s: FloatArray) -> "_Lowest | None":
        """Return the smallest of h, shape (barriers, N); ``None`` without barriers."""
        if not h.shape[0]:
            return None
        lowest = [Extremum.lowest(values, t_s) for values in h]
        barrier = min(range(len(lowest)), key=lowest.__getitem__)
        return cls(lowest[barrier], barrier)


def _between(
    trajectory: Trajectory, evaluator: PlantEvaluator, points: int, lowest: _Lowest | None
) -> tuple[_Lowest | None, Extremum | None]:
    """Return the lowest barrier value, that at samples included, and the lowest power margin between samples."""
    power_min: Extremum | None = None
    for instants in trajectory.between(evaluator, points):
        found = _Lowest.of(evaluator.h(instants.x, instants.t_s), instants.t_s)
        if lowest is not None and found is not None:
            lowest = min(lowest, found)
        margin = evaluator.power_margin(instants.x, instants.u)
        power_min = _smaller(power_min, Extremum.lowest(margin, instants.t_s))
    return lowest, power_min


def _smaller(a: Extremum | None, b: Extremum) -> Extremum:
    return b if a is None else min(a, b)
