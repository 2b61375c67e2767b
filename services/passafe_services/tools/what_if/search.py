"""Searches for the value of a key at which the verdict on a what-if changes."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from pydantic import BaseModel, ConfigDict

SAMPLES: Final = 5
"""Values that are tried first, evenly spread, both ends among them: they show whether there is one change only."""


class Trial(BaseModel):
    """One value that was tried.

    Attributes:
        value: The value.
        verdict: Verdict on its run; ``refused`` if the value makes no run.
        h_min: Smallest barrier value of it.
        words: The verdict in a sentence, or why it was refused.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    value: float
    verdict: str
    h_min: float | None
    words: str


class SearchResult(BaseModel):
    """Result of a search, as far as it went.

    Attributes:
        key: The key.
        low: Lower end of what was searched.
        high: Upper end.
        tolerance: Width of the interval that was asked for.
        trials: Values that were tried, in order of value.
        same_up_to: Largest value below the first change with the verdict of the lower end.
        differs_from: Smallest value with another verdict; ``None`` if none was found: not found is not never.
        is_monotone: Whether no value beyond the first change has the verdict of the lower end again.
        is_finished: Whether the interval is as narrow as asked; false when the search was interrupted or ran out.
        was_interrupted: Whether it was interrupted.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    key: str
    low: float
    high: float
    tolerance: float
    trials: tuple[Trial, ...]
    same_up_to: float | None
    differs_from: float | None
    is_monotone: bool
    is_finished: bool
    was_interrupted: bool = False

    @property
    def text(self) -> str:
        """The result in a sentence."""
        if not self.trials:
            return f"{self.key}: nothing was tried"
        first = self.trials[0].verdict
        if self.differs_from is None:
            text = f"{self.key}: no change of the verdict found from {self.low:g} to {self.high:g}: {first}"
            return f"{text} at all {len(self.trials)} values tried"
        after = next(trial.verdict for trial in self.trials if trial.value == self.differs_from)
        text = f"{self.key}: {first} up to {self.same_up_to:.6g}, {after} from {self.differs_from:.6g} on"
        if not self.is_monotone:
            text += f"; not monotone: {first} again at a value beyond"
        return text if self.is_finished else text + "; not as narrow as asked"


@dataclass(frozen=True, kw_only=True)
class Search:
    """Search between two values.

    Attributes:
        key: The key.
        low: Lower end.
        high: Upper end, above it.
        tolerance: Width of the interval at which to end.
        most_runs: Largest number of runs.
    """

    key: str
    low: float
    high: float
    tolerance: float
    most_runs: int

    def values(self, found: Mapping[float, Trial]) -> Iterator[float]:
        """Yield the values to try; each is in ``found`` before the next one is asked for."""
        number = min(SAMPLES, self.most_runs)
        for k in range(number):
            share = k / max(number - 1, 1)
            yield self.low * (1 - share) + self.high * share  # a difference of the ends may exceed all numbers
        while len(found) < self.most_runs:
            result = self.result(found)
            below, above = result.same_up_to, result.differs_from
            if result.is_finished or below is None or above is None:
                return
            yield below / 2 + above / 2

    def run(self, attempt: Callable[[float], Trial]) -> SearchResult:
        """Search until the interval is narrow enough; an interrupt ends it with what was found.

        Args:
            attempt: Makes the run of a value.
        """
        found: dict[float, Trial] = {}
        try:
            for value in self.values(found):
                found[value] = attempt(value)
        except KeyboardInterrupt:
            return self.result(found).model_copy(update={"was_interrupted": True})
        return self.result(found)

    def result(self, found: Mapping[float, Trial]) -> SearchResult:
        """Return the result of the values that were tried."""
        trials = [found[value] for value in sorted(found)]
        below: float | None = None
        above: float | None = None
        again = False
        for trial in trials:
            if trial.verdict != trials[0].verdict:
                above = trial.value if above is None else above
            elif above is None:
                below = trial.value
            else:
                again = True
        has_ends = self.high in found and len(found) >= min(SAMPLES, self.most_runs)
        is_narrow = above is not None and below is not None and above - below <= self.tolerance
        return SearchResult(
            key=self.key,
            low=self.low,
            high=self.high,
            tolerance=self.tolerance,
            trials=tuple(trials),
            same_up_to=below,
            differs_from=above,
            is_monotone=not again,
            is_finished=is_narrow or (above is None and has_ends),
        )
