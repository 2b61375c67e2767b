"""Feasibility atlas: the findings in every cell of a slice and at random states, as a table and as counts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TextIO

import numpy as np

from passafe_services.tools.feasibility.constraint_feasibility import Findings
from passafe_services.tools.feasibility.grid import Grid
from passafe_services.tools.feasibility.share import Share
from passafe_services.tools.runs.record import SweepRecord

LIMITATION: Final = (
    "Each state is evaluated on its own, without rate limits: feasible rows at a state do not imply feasible rows at "
    "the states that follow."
)


class Counts(SweepRecord):
    """Counts of a set of states; the last three count states inside the protected set only.

    Attributes:
        states: All states.
        inside: States in the set that the rows protect.
        hard: States with feasible hard rows.
        passive: States with feasible hard rows and passivity.
        unsettled: States at which the search for a larger margin ended early.
    """

    states: int
    inside: int
    hard: int
    passive: int
    unsettled: int

    @classmethod
    def of(cls, found: Findings) -> "Counts":
        """Count the findings."""
        inside = found.inside
        return cls(
            states=inside.size,
            inside=int(inside.sum()),
            hard=int((inside & found.hard_kept).sum()),
            passive=int((inside & found.passive_kept).sum()),
            unsettled=int((inside & found.unsettled).sum()),
        )


class SampleSummary(SweepRecord):
    """Random states in a box, and the estimated shares.

    Attributes:
        low: Lower corner of the box.
        high: Upper corner of the box.
        seed: Seed of the states.
        counts: Counts of the states.
        inside: Share of the box inside the set that the rows protect.
        hard: Share of that set with feasible hard rows.
        passive: Share of that set with feasible hard rows and passivity.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    seed: int
    counts: Counts
    inside: Share
    hard: Share
    passive: Share

    @classmethod
    def of(cls, found: Findings, low: Sequence[float], high: Sequence[float], seed: int) -> "SampleSummary":
        """Summarize the findings at the states that ``random_states`` draws for these arguments."""
        counts = Counts.of(found)
        return cls(
            low=tuple(low),
            high=tuple(high),
            seed=seed,
            counts=counts,
            inside=Share.counted(counts.inside, counts.states),
            hard=Share.counted(counts.hard, counts.inside),
            passive=Share.counted(counts.passive, counts.inside),
        )


class AtlasSummary(SweepRecord):
    """Summary of an atlas.

    Attributes:
        scenario: Name of the scenario.
        across: Coordinate from left to right.
        up: Coordinate from bottom to top.
        fixed: State whose other coordinates are fixed.
        plant_time_s: Plant time at which moving barriers are evaluated, s.
        slice: Counts of the cells.
        sample: Random states, if any.
        limitation: Limitation of the method.
    """

    scenario: str
    across: int
    up: int
    fixed: tuple[float, ...]
    plant_time_s: float
    slice: Counts
    sample: SampleSummary | None
    limitation: str = LIMITATION


@dataclass(frozen=True, kw_only=True, slots=True)
class Atlas:
    """Findings in every cell of a slice.

    Attributes:
        scenario: Name of the scenario.
        grid: The cells.
        plant_time_s: Plant time at which moving barriers are evaluated, s.
        found: Findings of every cell, row by row from the lowest.
    """

    scenario: str
    grid: Grid
    plant_time_s: float
    found: Findings

    def summary(self, sample: SampleSummary | None) -> AtlasSummary:
        """Return the summary, with that of random states."""
        return AtlasSummary(
            scenario=self.scenario,
            across=self.grid.across.index,
            up=self.grid.up.index,
            fixed=self.grid.fixed,
            plant_time_s=self.plant_time_s,
            slice=Counts.of(self.found),
            sample=sample,
        )

    def write_csv(self, file: TextIO) -> None:
        """Write one row per cell: its state, h, the smallest ψ, margins in units of u, and the flags."""
        found = self.found
        numbers = {
            **{f"x{i}": values for i, values in enumerate(found.states)},
            "h": found.h,
            "protecting": found.protecting,
            "hard_margin": found.hard_margin,
            "passive_margin": found.passive_margin,
        }
        flags = {
            "inside": found.inside,
            "hard_kept": found.hard_kept,
            "passive_kept": found.passive_kept,
            "unsettled": found.unsettled,
        }
        columns = numbers | flags
        formats = ["%.9g"] * len(numbers) + ["%d"] * len(flags)
        table = np.column_stack(list(columns.values()))
        np.savetxt(file, table, formats, delimiter=",", header=",".join(columns), comments="")
