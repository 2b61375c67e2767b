"""The property that no input was beyond its limits: axes, sides, norms, half-spaces and rates."""

import numpy as np

from passafe.limits import Limits
from passafe_services.scenarios.design import limits_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import SentInputs
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.property import Property, at_most
from passafe_services.tools.review.trajectory import NS_PER_S


class InputLimitRecord:
    """Largest inputs of a run beside their limits, as they come.

    Rates count between inputs that follow one another in an input sequence; the fail-safe begins with a jump.

    Args:
        scenario: Has the limits.
        tolerance: Of the limits, relative to the largest magnitude.
    """

    def __init__(self, scenario: Scenario, tolerance: float) -> None:
        self._limits = limits_of(scenario, robot_of(scenario))
        self._period_s = scenario.dt_s
        self._tolerance = tolerance
        self._worst: Extremum | None = None
        self._newest: dict[int, SentInputs] = {}

    def take_applied(self, u: FloatArray, t_s: FloatArray) -> None:
        """Take inputs that were in force, shape (m, N), and the plant times of their beginning, s, shape (N,)."""
        if t_s.size:
            self._take(Extremum.highest(_used(u, self._limits), t_s))

    def take_sent(self, inputs: SentInputs, *, session: int) -> None:
        """Take inputs that a session of the filter sent, in order."""
        if not inputs.at_ns.size:
            return
        limits = self._limits
        self._take(Extremum.highest(_used(inputs.u, limits), inputs.at_ns / NS_PER_S))
        before = self._newest.get(session)
        joined = inputs if before is None else before.followed_by(inputs)
        self._newest[session] = inputs.last()
        follows = joined.follows(self._period_s)
        if limits.rise_per_s is not None and follows.any():
            excess = limits.excess(joined.u[:, 1:], joined.u[:, :-1], self._period_s)[follows]
            self._take(Extremum.highest(excess, joined.at_ns[1:][follows] / NS_PER_S))

    def property(self) -> Property:
        """Return the property that every input that was sent or applied is within the limits."""
        bound = max(self._limits.magnitude)
        if _is_one_bound(self._limits):
            limit = bound * (1 + self._tolerance)
            return at_most(self._worst, limit, required=True, what="largest |u_i| sent or applied")
        what = "input sent or applied beyond a limit by"
        return at_most(self._worst, bound * self._tolerance, required=True, what=what)

    def _take(self, found: Extremum) -> None:
        if self._worst is None or found.value > self._worst.value:
            self._worst = found


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
