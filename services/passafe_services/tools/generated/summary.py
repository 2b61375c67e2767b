"""The summary of a generated campaign: a line for each family, and the seeds of what went wrong."""

from collections import Counter
from collections.abc import Sequence
from typing import Final, Self

from passafe_services.tools.generated.loop_result import LoopResult
from passafe_services.tools.runs.record import SweepRecord

SHOWN: Final = 20
"""Seeds of each kind of failure, at most."""

LEAST_ACCEPTED: Final = 0.8
"""Share of designs with a feasible oracle that must be accepted."""


class FamilySummary(SweepRecord):
    """The loops of one family.

    Attributes:
        family: Name.
        loops: How many.
        counted: Those of accepted designs that started in the protected set, from where the check was clean.
        start_warned: Those of accepted designs that started in the protected set, but where the check was not; it is
            made where something went wrong.
        safe: Of these, those with h ≥ 0 at and between samples.
        unsafe_seeds: The others, those without a fallback first.
        unsafe_without_fallback: How many of the others never entered a fallback.
        h_worst: Least h of the counted loops.
        insolvent_seeds: Counted loops whose tank fell below zero and below what the slack accounts for.
        tank_worst: Least tank of the counted loops, as a share of its first level; ``None`` without one.
        beyond_limits_seeds: Loops with an input beyond a limit.
        overreach_worst: Largest share by which an input was beyond a limit.
        fallback_share: Share of ticks in a fallback, of the counted loops.
        entries: How often loops entered a fallback.
        braking_better_seeds: Loops in which braking alone would have done better.
        feasible: Loops of designs with a feasible oracle.
        feasible_accepted: Of these, those of accepted designs.
        feasible_as_drawn: Of these, those that were accepted as they were drawn, without the gatekeeper that the check
            advises.
        refused: Loops of refused designs.
        warned: Loops of designs with warnings.
        statuses: How many ticks of each.
    """

    family: str
    loops: int
    counted: int
    start_warned: int
    safe: int
    unsafe_seeds: tuple[int, ...]
    unsafe_without_fallback: int
    h_worst: float
    insolvent_seeds: tuple[int, ...]
    tank_worst: float | None
    beyond_limits_seeds: tuple[int, ...]
    overreach_worst: float
    fallback_share: float
    entries: int
    braking_better_seeds: tuple[int, ...]
    feasible: int
    feasible_accepted: int
    feasible_as_drawn: int
    refused: int
    warned: int
    statuses: dict[str, int]

    @classmethod
    def of(cls, family: str, results: Sequence[LoopResult]) -> Self:
        """Summarise the loops of one family, at least one."""
        run = [result for result in results if not result.is_refused]
        counted = [result for result in run if result.counts]
        feasible = [result for result in results if result.oracle_share == 1.0]
        statuses: Counter[str] = Counter()
        for result in run:
            statuses.update(result.statuses)
        unsafe = sorted((r for r in counted if not r.is_safe), key=lambda r: (r.fallback_ticks > 0, r.seed))
        tanks = [r.tank_min_j / r.tank_start_j for r in counted if r.tank_min_j is not None and r.tank_start_j]
        return cls(
            family=family,
            loops=len(results),
            counted=len(counted),
            start_warned=sum(bool(result.start_warning) for result in run),
            safe=len(counted) - len(unsafe),
            unsafe_seeds=_seeds(unsafe),
            unsafe_without_fallback=sum(r.fallback_ticks == 0 for r in unsafe),
            h_worst=min((r.h_min for r in counted), default=0.0),
            insolvent_seeds=_seeds([r for r in counted if not r.is_solvent]),
            tank_worst=min(tanks, default=None),
            beyond_limits_seeds=_seeds([r for r in run if not r.is_within_limits]),
            overreach_worst=max((r.overreach for r in run), default=-1.0),
            fallback_share=sum(r.fallback_ticks for r in counted) / max(sum(r.ticks for r in counted), 1),
            entries=sum(r.entries for r in run),
            braking_better_seeds=_seeds([r for r in run if r.braking_better]),
            feasible=len(feasible),
            feasible_accepted=sum(r.is_accepted for r in feasible),
            feasible_as_drawn=sum(r.is_accepted and not r.gatekeeper_advised for r in feasible),
            refused=len(results) - len(run),
            warned=sum(bool(r.warnings) for r in run),
            statuses=dict(statuses),
        )

    @property
    def holds(self) -> bool:
        """True if every counted loop was safe and solvent, every input within limits, and braking never better."""
        failures = (self.unsafe_seeds, self.insolvent_seeds, self.beyond_limits_seeds, self.braking_better_seeds)
        return not any(failures)


class GeneratedSummary(SweepRecord):
    """All families.

    Attributes:
        families: One summary each, in the order of their names' first appearance.
    """

    families: tuple[FamilySummary, ...]

    @classmethod
    def of(cls, results: Sequence[LoopResult]) -> Self:
        """Summarise at least one result."""
        names = dict.fromkeys(result.family for result in results)
        return cls(families=tuple(FamilySummary.of(n, [r for r in results if r.family == n]) for n in names))

    @property
    def accepted_share(self) -> float:
        """Share of designs with a feasible oracle that were accepted; 1 if there is none."""
        return self._share_of_feasible(sum(family.feasible_accepted for family in self.families))

    @property
    def as_drawn_share(self) -> float:
        """Share of those that were accepted as they were drawn; 1 if there is none."""
        return self._share_of_feasible(sum(family.feasible_as_drawn for family in self.families))

    def _share_of_feasible(self, loops: int) -> float:
        feasible = sum(family.feasible for family in self.families)
        return loops / feasible if feasible else 1.0

    @property
    def holds(self) -> bool:
        """True if every family holds and enough of the feasible designs were accepted."""
        return all(family.holds for family in self.families) and self.accepted_share >= LEAST_ACCEPTED


def _seeds(results: Sequence[LoopResult]) -> tuple[int, ...]:
    return tuple(result.seed for result in results[:SHOWN])
