"""The property that no input was beyond its limits: axes, sides, norms, half-spaces and rates."""

import numpy as np

from passafe.limits import Limits
from passafe_services.scenarios.design import limits_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import SentInputs
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.property import Property, at_most
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory


def judge_inputs(inputs: SentInputs, trajectory: Trajectory, scenario: Scenario, tolerance: float) -> Property:
    """Return the property that every input that was sent or applied is within the limits.

    Rates count between inputs that follow one another in an input sequence; the fail-safe begins with a jump.

    Args:
        inputs: Inputs that the filter sent.
        trajectory: Motion of the plant, with the inputs that were in force.
        scenario: Has the limits.
        tolerance: Of the limits, relative to the largest magnitude.
    """
    limits = limits_of(scenario, robot_of(scenario))
    found = []
    if trajectory.samples:
        found.append(Extremum.highest(_used(trajectory.u, limits), trajectory.t_s))
    if inputs.at_ns.size:
        found.append(Extremum.highest(_used(inputs.u, limits), inputs.at_ns / NS_PER_S))
    follows = inputs.follows(scenario.dt_s)
    if limits.rise_per_s is not None and follows.any():
        excess = limits.excess(inputs.u[:, 1:], inputs.u[:, :-1], scenario.dt_s)[follows]
        found.append(Extremum.highest(excess, inputs.at_ns[1:][follows] / NS_PER_S))
    worst = max(found, key=lambda extremum: extremum.value, default=None)
    bound = max(limits.magnitude)
    if _is_one_bound(limits):
        return at_most(worst, bound * (1 + tolerance), required=True, what="largest |u_i| sent or applied")
    return at_most(worst, bound * tolerance, required=True, what="input sent or applied beyond a limit by")


def _is_one_bound(limits: Limits) -> bool:
    if limits.rise_per_s is not None or not limits.has_only_axes:
        return False
    return {*limits.high, *(-low for low in limits.low)} == {max(limits.magnitude)}


def _used(u: FloatArray, limits: Limits) -> FloatArray:
    """Return the largest |uᵢ| where one number limits all axes, else by how much inputs are beyond a limit."""
    if _is_one_bound(limits):
        largest: FloatArray = np.abs(u).max(axis=0)
        return largest
    return limits.excess(u)
