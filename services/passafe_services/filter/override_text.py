"""Describes in a sentence what the filter overrode and why."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from passafe.answers.replaced_answer import BACKUP
from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.models.robot import Robot
from passafe.override import Override
from passafe.symbolic.rows import PASSIVITY_ROW
from passafe_services.filter.barrier_distance import BarrierDistance
from passafe_services.filter.member_rows import without_member

LEAST_SHARE: Final = 0.1
"""Share of the change above which a row is named beside the first."""

MOST_NAMED: Final = 3

LEAST_REPORTED: Final = 1e-3
"""Change of the command below which none is reported, units of u."""

BALANCED: Final = 1e-3
"""Norm of the weighted sum of the relaxed rows, relative to the weights, below which they conflict among themselves."""

INPUT_LIMIT: Final = "input limit"


class OverrideText:
    """Describes the overrides of one filter."""

    def __init__(self, core: SafetyPassivityFilter, robot: Robot, unit: str) -> None:
        """Prepare the names of rows and the distances to barriers.

        Args:
            core: The filter.
            robot: The plant of its design.
            unit: Unit of u.
        """
        self._unit = unit
        self._row_names = core.row_names
        self._distances = {without_member(chain.barrier.name): BarrierDistance(chain, robot) for chain in core.chains}
        self._places = {name: i for i, name in enumerate(core.row_names[: core.constraints])}

    def causes(self, override: Override) -> tuple[str, ...]:
        """Return the names of the causes, the most important first; input limits share one name."""
        named: list[str] = []
        for cause in override.causes[:MOST_NAMED]:
            name = without_member(cause.row) if cause.row in self._places else INPUT_LIMIT
            if name not in named and (not named or cause.share >= LEAST_SHARE):
                named.append(name)
        return tuple(named)

    def sentence(self, decision: Decision, override: Override) -> str:
        """Return a sentence: what was held back by which rows, what would have passed, and what was relaxed."""
        parts = []
        causes = [self._cause(name, decision) for name in self.causes(override)]
        if causes and override.size >= LEAST_REPORTED:
            parts.append(f"held back {override.size:.2g} {self._unit}: {' and '.join(causes)}")
            parts.append(_allowed(override))
        if decision.status is Status.INFEASIBLE:
            parts.append(self._relaxation(decision))
        if decision.status is Status.RELAXED:
            parts.append(f"relaxed passivity by {decision.slack:.2g} W")
        return "; ".join(parts)

    def _cause(self, name: str, decision: Decision) -> str:
        if name == INPUT_LIMIT:
            return INPUT_LIMIT
        if name == PASSIVITY_ROW and name not in self._distances:
            return "energy"
        reading = self._distances[name].read(decision.part("x"), float(decision.part("t")[0]))
        if not reading.unit:
            return f"{self._label(name)}, h = {reading.value:.2g}"
        where = "from" if reading.value >= 0.0 else "beyond"
        return f"{self._label(name)}, {abs(reading.value):.2g} {reading.unit} {where} its limit"

    def _label(self, name: str) -> str:
        """Return the name of a hard row with its kind; under the continuous law passivity is one."""
        name = without_member(name)
        distance = self._distances.get(name)
        if distance is None:
            return "energy"
        return f"{'obstacle' if distance.is_obstacle else 'barrier'} `{name}`"

    def _relaxation(self, decision: Decision) -> str:
        relax, G = decision.answer.relax, decision.program.G
        order = [int(i) for i in np.argsort(-relax, kind="stable") if relax[i] > 0.0]
        if not order:
            sent = "the fail-safe law acts" if decision.solver == BACKUP else "what keeps the barriers longest is sent"
            return f"no input within the limits keeps every row: {sent}"
        amounts = [f"{relax[i]:.2g} {self._unit} of {self._label(self._row_names[i])}" for i in order]
        alone = float(np.linalg.norm(relax @ G[: relax.size])) <= BALANCED * float(relax.sum())
        return f"relaxed {_listed(amounts)}: {_conflict(len(order), alone=alone)}"


def _allowed(override: Override) -> str:
    if override.unavoidable:
        return "no part of the command would have passed unchanged"
    # Rounded down, so that the reported fraction passes.
    return f"{int(100 * override.allowed_fraction)} % of the command would have passed unchanged"


def _conflict(count: int, *, alone: bool) -> str:
    if count == 1:
        return "it requires more than the input limits allow"
    return "they conflict" + ("" if alone else " within the input limits")


def _listed(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
