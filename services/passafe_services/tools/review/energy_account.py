"""Energy of the tank, recomputed from states and inputs: E ← min(E + ∫h_u dt, E_max), h_u = yᵀu − V̇.

The passivity row lets the power margin fall below what the tank allows by its slack δ alone. So the tank falls below
its reserve by no more than what was granted: E(t) ≥ E_r − ∫δ dt. While no input of the filter is in force, what the
plant's own law takes from the tank counts as granted.
"""

from typing import NamedTuple

import numpy as np

from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import Decisions, IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory


class EnergyAccount(NamedTuple):
    """Extrema of the tank of a run, at samples and between them.

    Attributes:
        tank_min_j: Smallest energy E, J.
        kept_min_j: Smallest E − E_r + ∫δ dt, J; ``None`` where it is not known which slack was in force.
    """

    tank_min_j: Extremum
    kept_min_j: Extremum | None


def account_of(
    trajectory: Trajectory,
    evaluator: PlantEvaluator,
    passivity: PassivityConfig,
    points: int,
    decisions: Decisions | None,
) -> EnergyAccount:
    """Return the account of a run with at least one sample.

    Args:
        trajectory: Motion of the plant.
        evaluator: Functions of the scenario.
        passivity: The tank.
        points: Instants to evaluate per period, its end included.
        decisions: Decisions of the filter, of which the slacks are taken.
    """
    gained_j = _gained(trajectory, evaluator)
    level_j = tank_ledger(gained_j, trajectory.session, passivity)
    slack_w = slack_in_force(trajectory, decisions)
    rates = np.zeros(trajectory.samples) if slack_w is None else slack_w
    lost_j = np.where(trajectory.runs[:-1], 0.0, np.maximum(-gained_j[1:], 0.0))
    granted_j = np.concatenate(([0.0], np.cumsum(rates[:-1] * np.diff(trajectory.t_s) + lost_j)))
    above_j = level_j - passivity.tank_reserve_j + granted_j
    tank, kept = Extremum.lowest(level_j, trajectory.t_s), Extremum.lowest(above_j, trajectory.t_s)
    for period_s in np.unique(trajectory.period_s[trajectory.period_s > 0]):
        begun = trajectory.period_s == period_s
        x, u, t_s = trajectory.x[:, begun], trajectory.u[:, begun], trajectory.t_s[begun]
        for j in range(1, points):
            after_s = float(period_s) * j / points
            gain_j = evaluator.energy_gain(x, u, after_s)
            tank = min(tank, Extremum.lowest(level_j[begun] + gain_j, t_s + after_s))
            granted = np.where(trajectory.runs[begun], rates[begun] * after_s, np.maximum(-gain_j, 0.0))
            kept = min(kept, Extremum.lowest(above_j[begun] + gain_j + granted, t_s + after_s))
    return EnergyAccount(tank, None if slack_w is None else kept)


def tank_ledger(gained_j: FloatArray, session: IntArray, passivity: PassivityConfig) -> FloatArray:
    """Return the energy of the tank at every sample, J, shape (N,); it begins at ``tank_initial_j`` in each session.

    Args:
        gained_j: ∫h_u dt since the sample before, J, shape (N,).
        session: Number of the plant's session, shape (N,).
        passivity: The tank.
    """
    ledger: list[float] = []
    before: int | None = None
    energy_j, initial_j, max_j = 0.0, passivity.tank_initial_j, passivity.tank_max_j
    for gain_j, its_session in zip(gained_j.tolist(), session.tolist(), strict=True):
        energy_j = min(energy_j + gain_j, max_j) if its_session == before else initial_j
        before = its_session
        ledger.append(energy_j)
    return np.array(ledger, dtype=np.float64)


def logged_gain(trajectory: Trajectory) -> FloatArray:
    """Return ∫h_u dt since the sample before by the plant's own account, J, shape (N,)."""
    gained: FloatArray = np.diff(trajectory.energy_in_j, prepend=0.0) - np.diff(trajectory.energy_stored_j, prepend=0.0)
    return gained


def slack_in_force(trajectory: Trajectory, decisions: Decisions | None) -> FloatArray | None:
    """Return the slack of the newest decision at every sample, W, shape (N,).

    Returns:
        ``None`` without decisions, and for several sessions of the plant: each begins at plant time 0.
    """
    if decisions is None or not decisions.at_ns.size or trajectory.session[-1] != trajectory.session[0]:
        return None
    order = np.argsort(decisions.at_ns, kind="stable")
    plant_ns = np.rint(trajectory.t_s * NS_PER_S).astype(np.int64)
    newest = np.searchsorted(decisions.at_ns[order], plant_ns, side="right") - 1
    slack: FloatArray = np.where(newest < 0, 0.0, decisions.slack_w[order][np.maximum(newest, 0)])
    return slack


def _gained(trajectory: Trajectory, evaluator: PlantEvaluator) -> FloatArray:
    """Return ∫h_u dt since the sample before, J; across missing samples, by the plant's own account."""
    gained = logged_gain(trajectory)
    for period_s in np.unique(trajectory.period_s[trajectory.period_s > 0]):
        (begun,) = np.nonzero(trajectory.period_s == period_s)
        gained[begun + 1] = evaluator.energy_gain(trajectory.x[:, begun], trajectory.u[:, begun], float(period_s))
    return gained
