"""Watches the assumption of the rows: every plant state against what the scenario's sets allow from those before."""

from typing import Final

from passafe_protocol.messages import Event, EventKind, PlantState, Vector

from passafe.state_set import ErrorGrowth, StateSet
from passafe_services.filter.input_path import InputPath
from passafe_services.plant_contract.state_estimate import StateEstimate

QUIET_PERIOD_NS: Final = 1_000_000_000
"""Least time between two events, ns; the next one has the largest factor of those between."""


class ModelWatch:
    """Compares every state with the set of those that the ones before allow, and reports violations.

    Attributes:
        violations: Number of states outside of what the sets allow.
    """

    def __init__(self, growth: ErrorGrowth) -> None:
        """Start with nothing received.

        Args:
            growth: Growth of errors by the scenario's sets.
        """
        self._estimate = StateEstimate(growth)
        self.restart()

    def restart(self) -> None:
        """Forget all states: the plant was restarted."""
        self._estimate.restart()
        self._before: PlantState | None = None
        self.violations = 0
        self._worst: tuple[float, int] | None = None
        self._quiet_until_ns = 0

    @property
    def residual(self) -> Vector:
        """Factors of the newest state, n; empty where there was none to compare with."""
        return self._estimate.residual

    def observe(self, state: PlantState, path: InputPath) -> StateSet:
        """Return the set of states in which the plant is, after its newest state."""
        before, self._before = self._before, state
        inputs = None if before is None else path.inputs_between(before, state)
        newest = self._estimate.observe(state.x, inputs)
        if self._estimate.is_violated:
            self.violations += 1
            worst = max((factor, i) for i, factor in enumerate(self._estimate.residual))
            self._worst = worst if self._worst is None else max(self._worst, worst)
        return newest

    def event(self, now_ns: int) -> Event | None:
        """Return an event if a violation has not been reported yet, at most once a second."""
        if self._worst is None or now_ns < self._quiet_until_ns:
            return None
        factor, axis = self._worst
        self._worst, self._quiet_until_ns = None, now_ns + QUIET_PERIOD_NS
        name = f"x[{axis}]"
        text = (
            f"{EventKind.MODEL_VIOLATED} {self.violations}: {name} lies {factor:.3g} times as far from the model's "
            "prediction as the scenario's sets allow"
        )
        return Event("error", text, EventKind.MODEL_VIOLATED, self.violations, name, factor)
