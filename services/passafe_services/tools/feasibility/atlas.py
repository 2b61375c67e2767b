"""A finished map: what was found in every cell of a slice and at random states, as a table and in sums."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TextIO

from pydantic import BaseModel, ConfigDict

from passafe_services.tools.feasibility.constraint_feasibility import Findings
from passafe_services.tools.feasibility.grid import Grid
from passafe_services.tools.feasibility.share import Share

WHAT_IT_SAYS: Final = (
    "Each state by itself, limits of the rate left out: that its rows can be kept does not say that those of the "
    "states it leads to can."
)


class Counts(BaseModel):
    """How many of a set of states answer each question with yes; the last three count states inside only.

    Attributes:
        states: All of them.
        inside: In the set that the rows protect.
        hard: The hard rows can be kept.
        passive: The hard rows and passivity can be kept.
        unsettled: The search for a larger margin was ended early.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    states: int
    inside: int
    hard: int
    passive: int
    unsettled: int

    @classmethod
    def of(cls, found: Findings) -> "Counts":
        """Count what was found."""
        inside = found.inside
        return cls(
            states=inside.size,
            inside=int(inside.sum()),
            hard=int((inside & found.hard_kept).sum()),
            passive=int((inside & found.passive_kept).sum()),
            unsettled=int((inside & found.unsettled).sum()),
        )


class SampleSummary(BaseModel):
    """Random states of a box, and the shares that they show.

    Attributes:
        low: The box's least corner.
        high: Its largest.
        seed: Decides all states.
        counts: How many.
        inside: Share of the box inside the set that the rows protect.
        hard: Share of that set where the hard rows can be kept.
        passive: Share of it where the hard rows and passivity can be kept.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    low: tuple[float, ...]
    high: tuple[float, ...]
    seed: int
    counts: Counts
    inside: Share
    hard: Share
    passive: Share

    @classmethod
    def of(cls, found: Findings, low: Sequence[float], high: Sequence[float], seed: int) -> "SampleSummary":
        """Sum up what was found at the states that ``random_states`` draws for these arguments."""
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


class AtlasSummary(BaseModel):
    """What a map came to.

    Attributes:
        scenario: Name.
        across: Coordinate from left to right.
        up: Coordinate from bottom to top.
        fixed: The whole state from which only those two differ.
        plant_time_s: Where moving barriers are.
        slice: Cells of the map.
        sample: Random states, if any.
        what_it_says: What must not be read out of it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: str
    across: int
    up: int
    fixed: tuple[float, ...]
    plant_time_s: float
    slice: Counts
    sample: SampleSummary | None
    what_it_says: str = WHAT_IT_SAYS


@dataclass(frozen=True, kw_only=True, slots=True)
class Atlas:
    """A finished map.

    Attributes:
        scenario: Name.
        grid: Its cells.
        plant_time_s: Where moving barriers are.
        found: What was found in every cell, row by row from the lowest.
    """

    scenario: str
    grid: Grid
    plant_time_s: float
    found: Findings

    def summary(self, sample: SampleSummary | None) -> AtlasSummary:
        """Return what it came to, with what random states show beside it."""
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
        """Write one row a cell: its state, h, the protecting functions, margins in units of u, and the answers."""
        found = self.found
        columns = {
            **{f"x{i}": values for i, values in enumerate(found.states)},
            "h": found.h,
            "protecting": found.protecting,
            "hard_margin": found.hard_margin,
            "passive_margin": found.passive_margin,
        }
        answers = {
            "inside": found.inside,
            "hard_kept": found.hard_kept,
            "passive_kept": found.passive_kept,
            "unsettled": found.unsettled,
        }
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*columns, *answers])
        numbers = [[f"{value:.9g}" for value in column] for column in columns.values()]
        flags = [[int(flag) for flag in answer] for answer in answers.values()]
        writer.writerows(zip(*numbers, *flags, strict=True))
