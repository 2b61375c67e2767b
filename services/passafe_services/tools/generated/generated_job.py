"""The loops of a generated campaign, as workers and the results file see them."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Final

import numpy as np

from passafe.errors import DesignError
from passafe.finding import Severity
from passafe.numerics.workspace import Array
from passafe_services.tools.generated.accepted_design import (
    built,
    check_warnings,
    guarded,
    start_of_check,
    start_warning,
)
from passafe_services.tools.generated.closed_loop import ClosedLoop, LoopTrace
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.loop_plan import LoopPlan
from passafe_services.tools.generated.loop_result import ROUNDING, LoopResult
from passafe_services.tools.generated.protected_set import ProtectedSet
from passafe_services.tools.runs.results_file import ResultsFile, ResultsHeading

LOOPS: Final = 8
"""Loops of every design: seed s is loop s mod 8 of design ⌊s/8⌋."""

MOST_DESIGNS: Final = 5
"""Designs of one chunk, at most: results come every few seconds."""

COMPARED: Final = 3
"""Entries into a fallback of each loop from which braking is rolled out, at most."""

MOST_FALLBACKS: Final = 40
"""Ticks in a fallback after which a loop without the promise h ≥ 0 ends: each costs as much as a hundred others."""

BETTER: Final = 1e-6
"""By how much more h braking has to keep, relative to 1 + |h|, to count as better where both last equally long."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedJob:
    """All that the loops of a generated campaign have in common; a task is a seed.

    Attributes:
        loops: How many belong to one design.
    """

    loops: int = LOOPS

    def compile(self) -> Callable[[Sequence[int]], list[LoopResult]]:
        """Return the function from seeds to the results of their loops."""
        return self._run

    def chunk_size(self, seeds: int, workers: int) -> int:
        """Return how many loops a chunk has: whole designs, a few chunks for each worker, a hundred loops at most.

        Args:
            seeds: How many loops there are.
            workers: How many workers.
        """
        designs = min(MOST_DESIGNS, -(-seeds // (4 * self.loops * workers)))
        return designs * self.loops

    def _run(self, seeds: Sequence[int]) -> list[LoopResult]:
        results: list[LoopResult] = []
        for number, members in groupby(seeds, key=lambda seed: seed // self.loops):
            results += loops_of(GeneratedDesign.of(number), list(members))
        return results


def loops_of(design: GeneratedDesign, seeds: Sequence[int]) -> list[LoopResult]:
    """Return the results of some loops of one design.

    Args:
        design: The design.
        seeds: One for each loop.
    """
    known = LoopResult(
        seed=0,
        family=design.family,
        rate_hz=1 / design.timing.dt_s,
        hold_s=design.timing.held_s,
        oracle_share=design.oracle_share,
    )
    protected = ProtectedSet(design.plant, design.chains)
    x0 = start_of_check(design, protected)
    try:
        core = built(design, x0)
    except DesignError as error:
        return [known.model_copy(update={"seed": seed, "refusal": str(error)}) for seed in seeds]
    found = check_warnings(design, core, x0)
    advised = guarded(design, core, x0) if found and not core.design.gatekeeper else None
    is_advised = advised is not None and not check_warnings(design, advised, x0)
    if advised is not None and is_advised:
        core, found = advised, ()
    said = {
        "warnings": tuple(text for _, text in found),
        "gatekeeper": core.design.gatekeeper,
        "gatekeeper_advised": is_advised,
    }
    known = known.model_copy(update=said)
    if any(severity is Severity.REFUSED for severity, _ in found):
        return [known.model_copy(update={"seed": seed, "refusal": known.warnings[0]}) for seed in seeds]
    loop = ClosedLoop(design, core)
    return [_result(known.model_copy(update={"seed": seed}), design, loop, protected) for seed in seeds]


def _result(known: LoopResult, design: GeneratedDesign, loop: ClosedLoop, protected: ProtectedSet) -> LoopResult:
    """Return the result of one loop.

    The check of its own start takes longer than the loop, and could only leave it out of those that count: it is made
    where something went wrong, or where the loop would go on.
    """
    plan = LoopPlan.of(known.seed, design, protected)
    trace = loop.run(plan, MOST_FALLBACKS)
    result = _judged(known, design, loop, plan, trace, protected.least_h(plan.x))
    went_well = result.is_safe and result.is_solvent and not result.braking_better
    if not (known.is_accepted and plan.started_inside) or (went_well and len(trace.lowest) == len(plan.arrives)):
        return result
    warning = start_warning(loop.core, plan.x.tolist(), known.seed)
    if not warning and result.fallback_ticks >= MOST_FALLBACKS:
        result = _judged(known, design, loop, plan, loop.run(plan), protected.least_h(plan.x))
    return result.model_copy(update={"start_warning": warning})


def _judged(
    known: LoopResult, design: GeneratedDesign, loop: ClosedLoop, plan: LoopPlan, trace: LoopTrace, h_start: float
) -> LoopResult:
    entries, lowest = trace.entries(), trace.lowest
    better = [first for first in entries[:COMPARED] if keeps_longer(loop.brake(plan, trace, first), trace.h(first))]
    tank, reserve_j = design.tank, design.tank.reserve_j if design.tank else 0.0
    return known.model_copy(
        update={
            "started_inside": plan.started_inside,
            "operator": plan.operator_name,
            "lost": int((~plan.arrives[: len(lowest)]).sum()),
            "ticks": len(lowest),
            "statuses": dict(Counter(status.name for status in trace.statuses)),
            "h_start": h_start,
            "h_min": min((each.h for each in lowest), default=h_start),
            "psi_min": min((each.psi for each in lowest), default=0.0),
            "tank_min_j": min((each.tank_j for each in lowest), default=tank.initial_j) if tank else None,
            "tank_start_j": tank.initial_j if tank else 0.0,
            "accounted_min_j": min(trace.accounted_j, default=tank.initial_j) - reserve_j if tank else None,
            "overreach": trace.overreach,
            "fallback_ticks": sum(status.is_fallback for status in trace.statuses),
            "entries": len(entries),
            "braking_better": len(better),
        }
    )


def keeps_longer(braking: Array, filtered: Array) -> bool:
    """Return whether one course of h outlasts another that falls below zero, or falls less deep at the same time.

    Args:
        braking: Least h of every period under braking alone.
        filtered: The same under the filter, over the same periods.
    """
    lasted, least = _first_below(filtered), float(filtered.min())
    if lasted is None:
        return False
    outlasted = _first_below(braking)
    if outlasted != lasted:
        return outlasted is None or outlasted > lasted
    return float(braking.min()) > least + BETTER * (1 + abs(least))


def _first_below(h: Array) -> int | None:
    below = np.flatnonzero(h < -ROUNDING)
    return int(below[0]) if below.size else None


def generated_results(path: Path) -> ResultsFile[int, LoopResult]:
    """Open the results file of a generated campaign, or begin it.

    Raises:
        ResultsFileError: It holds results of something else, or no results.
    """
    heading = ResultsHeading.of("generated campaign", {"loops": LOOPS})
    return ResultsFile(path, heading, LoopResult, lambda result: result.seed)
