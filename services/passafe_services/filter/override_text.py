"""What the filter changed, and why, in a sentence."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.models.robot import Robot
from passafe.override import Override
from passafe.rows import PASSIVITY_ROW
from passafe_services.filter.barrier_distance import BarrierDistance

LEAST_SHARE: Final = 0.1
"""Share of the change from which a row is named beside the first."""

MOST_NAMED: Final = 3

LEAST_TOLD: Final = 1e-3
"""Change of the command below which none is told, units of u."""

BALANCED: Final = 1e-3
"""Pull of the rows that were given up, relative to their weights, below which they alone contradict one another."""

INPUT_LIMIT: Final = "input limit"


class OverrideText:
    """Puts the overrides of one filter into words."""

    def __init__(self, core: SafetyPassivityFilter, robot: Robot, unit: str) -> None:
        """Take what the words need.

        Args:
            core: The filter.
            robot: The plant of its design.
            unit: Of u.
        """
        self._unit = unit
        self._row_names, self._duties = core.row_names, core.duties
        self._gauges = {chain.barrier.name: BarrierDistance(chain, robot) for chain in core.chains}
        self._places = {name: i for i, name in enumerate(core.row_names[: core.duties])}

    def reasons(self, override: Override) -> tuple[str, ...]:
        """Return the rows to name, limits of the input under one name, the most important first."""
        named: list[str] = []
        for cause in override.causes[:MOST_NAMED]:
            name = cause.row if cause.row in self._places else INPUT_LIMIT
            if name not in named and (not named or cause.share >= LEAST_SHARE):
                named.append(name)
        return tuple(named)

    def sentence(self, decision: Decision, override: Override) -> str:
        """Return what was held back by which rows, what of the command would have passed, and what was given up."""
        parts = []
        causes = [self._cause(name, decision) for name in self.reasons(override)]
        if causes and override.size >= LEAST_TOLD:
            parts.append(f"held back {override.size:.2g} {self._unit}: {' and '.join(causes)}")
            parts.append(_allowed(override))
        if decision.status is Status.INFEASIBLE:
            parts.append(self._given_up(decision))
        if decision.status is Status.RELAXED:
            parts.append(f"gave up {decision.slack:.2g} W of passivity")
        return "; ".join(parts)

    def _cause(self, name: str, decision: Decision) -> str:
        if name == INPUT_LIMIT:
            return INPUT_LIMIT
        if name == PASSIVITY_ROW and name not in self._gauges:
            return "energy"
        reading = self._gauges[name].read(decision.part("x"), float(decision.part("t")[0]))
        if not reading.unit:
            return f"{self._called(name)}, h = {reading.value:.2g}"
        where = "from" if reading.value >= 0.0 else "beyond"
        return f"{self._called(name)}, {abs(reading.value):.2g} {reading.unit} {where} its limit"

    def _called(self, name: str) -> str:
        """Return a hard row's name with its kind; under the continuous law passivity is one."""
        gauge = self._gauges.get(name)
        if gauge is None:
            return "energy"
        return f"{'obstacle' if gauge.is_obstacle else 'barrier'} `{name}`"

    def _given_up(self, decision: Decision) -> str:
        relax = decision.part("relax")
        order = [int(i) for i in np.argsort(-relax, kind="stable") if relax[i] > 0.0]
        amounts = [f"{relax[i]:.2g} {self._unit} of {self._called(self._row_names[i])}" for i in order]
        G = decision.part("G").reshape((self._duties, -1), order="F")[: relax.size]
        alone = float(np.linalg.norm(relax @ G)) <= BALANCED * float(relax.sum())
        return f"gave up {_listed(amounts)}: {_contradiction(len(order), alone=alone)}"


def _allowed(override: Override) -> str:
    if override.unavoidable:
        return "no part of the command would have passed unchanged"
    # Rounded down: what is said to pass does.
    return f"{int(100 * override.allowed_fraction)} % of the command would have passed unchanged"


def _contradiction(count: int, *, alone: bool) -> str:
    if count == 1:
        return "it asks for more than the input limits allow"
    return "they contradict one another" + ("" if alone else " within the input limits")


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
