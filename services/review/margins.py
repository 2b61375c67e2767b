"""How near a run came to its limits, recomputed from the plant's states alone, also between samples."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from services.review.mathematics import FloatArray, PlantMathematics
from services.review.trajectory import Trajectory
from services.scenarios.schema import PassivityConfig


class Extremum(NamedTuple):
    """A worst value and the plant time, s, at which it was taken."""

    value: float
    at_s: float

    @classmethod
    def lowest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """The smallest of at least one value; what is no number counts as −∞."""
        known = np.where(np.isnan(values), -np.inf, values)
        where = int(np.argmin(known))
        return cls(float(known[where]), float(t_s[where]))

    @classmethod
    def highest(cls, values: FloatArray, t_s: FloatArray) -> Self:
        """The largest of at least one value; what is no number counts as +∞."""
        lowest = cls.lowest(-values, t_s)
        return cls(-lowest.value, lowest.at_s)


@dataclass(frozen=True, kw_only=True)
class Margins:
    """How near a run came to its limits; ``None`` where there is nothing to take it from.

    Attributes:
        h_min: Smallest barrier value, at samples and between them.
        h_min_at_samples: The same at samples only: what the filter could act on.
        power_margin_min: Smallest power margin h_u(x, u), W, at samples and between them.
        power_margin_min_at_samples: The same at samples only.
        tank_min_j: Smallest energy of the tank's ledger, J, at samples.
        u_norm_max: Largest ‖u‖₂ in force.
        mismatch_max: Largest ``Trajectory.mismatch``.
    """

    h_min: Extremum | None = None
    h_min_at_samples: Extremum | None = None
    power_margin_min: Extremum | None = None
    power_margin_min_at_samples: Extremum | None = None
    tank_min_j: Extremum | None = None
    u_norm_max: Extremum | None = None
    mismatch_max: Extremum | None = None

    @classmethod
    def of(cls, trajectory: Trajectory, mathematics: PlantMathematics, passivity: PassivityConfig, points: int) -> Self:
        """Recompute them, with ``points`` instants in every period between two samples."""
        if trajectory.samples == 0:
            return cls()
        t_s, x, u = trajectory.t_s, trajectory.x, trajectory.u
        # A state of 1e200 overflows in x²; the extremum then says so, and a warning would say no more.
        with np.errstate(over="ignore", invalid="ignore"):
            h = _lowest_barrier(mathematics.h(x, t_s), t_s)
            power = Extremum.lowest(mathematics.power_margin(x, u), t_s)
            h_between, power_between = _between(trajectory, mathematics, points)
            mismatch, mismatch_t_s = trajectory.mismatch(mathematics)
            norms = np.linalg.norm(u, axis=0)
        return cls(
            h_min=_smaller(h, h_between),
            h_min_at_samples=h,
            power_margin_min=_smaller(power, power_between),
            power_margin_min_at_samples=power,
            tank_min_j=Extremum.lowest(tank_ledger(trajectory, passivity), t_s),
            u_norm_max=Extremum.highest(norms, t_s),
            mismatch_max=Extremum.highest(mismatch, mismatch_t_s) if mismatch.size else None,
        )


def tank_ledger(trajectory: Trajectory, passivity: PassivityConfig) -> FloatArray:
    """Energy of the tank, J, at every sample, from the plant's measured energies.

    E ← min(E + ∫yᵀu − ΔV, E_max) from one sample to the next, beginning at ``tank_initial_j``. Between two
    samples with messages missing it takes the sum at once.
    """
    gained = np.diff(trajectory.energy_in_j) - np.diff(trajectory.energy_stored_j)
    ledger = np.empty(trajectory.samples)
    session = None
    for k in range(trajectory.samples):
        if trajectory.session[k] != session:
            session = trajectory.session[k]
            energy_j = passivity.tank_initial_j
        else:
            energy_j = min(energy_j + float(gained[k - 1]), passivity.tank_max_j)
        ledger[k] = energy_j
    return ledger


def _between(
    trajectory: Trajectory, mathematics: PlantMathematics, points: int
) -> tuple[Extremum | None, Extremum | None]:
    h_min: Extremum | None = None
    power_min: Extremum | None = None
    for instants in trajectory.between(mathematics, points):
        h_min = _smaller(h_min, _lowest_barrier(mathematics.h(instants.x, instants.t_s), instants.t_s))
        margin = mathematics.power_margin(instants.x, instants.u)
        power_min = _smaller(power_min, Extremum.lowest(margin, instants.t_s))
    return h_min, power_min


def _lowest_barrier(h: FloatArray, t_s: FloatArray) -> Extremum | None:
    """Smallest over barriers and instants, for h of shape (barriers, N); ``None`` without barriers."""
    return Extremum.lowest(h.min(axis=0), t_s) if h.shape[0] else None


def _smaller(a: Extremum | None, b: Extremum | None) -> Extremum | None:
    if a is None or b is None:
        return b if a is None else a
    return min(a, b)
