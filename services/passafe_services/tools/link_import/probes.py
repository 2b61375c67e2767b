"""Probes of a network: when each was sent, and how long it took in one direction."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from math import inf, isinf
from statistics import fmean, median, quantiles
from typing import Final, NamedTuple

HUNDREDTHS: Final = 100

LOST: Final = inf
"""Delay of a lost probe."""


class Probe(NamedTuple):
    """One probe.

    Attributes:
        sent_s: Time of sending, s, from the first one.
        delay_s: Delay in one direction, s; infinite if it was lost.
    """

    sent_s: float
    delay_s: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Measurement:
    """Probes of one direction, with what was assumed to get them.

    Attributes:
        probes: In order of sending, two or more.
        assumptions: What the file does not say and was assumed, in sentences.
        duplicates: Answers that came twice or more, of which the first counts.
        reordered: Answers that came after one that was sent later.
        left_out: Probes about which nothing is known in this direction.
    """

    probes: tuple[Probe, ...]
    assumptions: tuple[str, ...]
    duplicates: int = 0
    reordered: int = 0
    left_out: int = 0

    @property
    def interval_s(self) -> float:
        """Median time between probes: losses that last less cannot be seen."""
        return median(later.sent_s - earlier.sent_s for earlier, later in pairwise(self.probes))

    def summary(self) -> list[str]:
        """Return lines that say what was measured."""
        arrived = [probe.delay_s for probe in self.probes if not isinf(probe.delay_s)]
        lost = len(self.probes) - len(arrived)
        duration_s = self.probes[-1].sent_s
        lines = [f"{len(self.probes)} probes in {duration_s:.3f} s, one every {1e3 * self.interval_s:.3g} ms"]
        if arrived:
            cuts = quantiles(arrived, n=HUNDREDTHS, method="inclusive") if len(arrived) > 1 else arrived * 99
            values = {"least": min(arrived), "median": cuts[49], "99 %": cuts[98], "most": max(arrived)}
            shown = ", ".join(f"{name} {1e3 * value:.3f}" for name, value in values.items())
            lines.append(f"delay ms: {shown}, mean {1e3 * fmean(arrived):.3f}")
        lines.append(f"lost: {lost} ({100 * lost / len(self.probes):.2f} %), longest run {self._longest_run()}")
        counts = {"duplicates": self.duplicates, "reordered": self.reordered, "left out": self.left_out}
        lines.append(", ".join(f"{name}: {count}" for name, count in counts.items()))
        return lines + [f"assumed: {one}" for one in self.assumptions]

    def _longest_run(self) -> int:
        runs = (sum(1 for _ in group) for lost, group in groupby(isinf(one.delay_s) for one in self.probes) if lost)
        return max(runs, default=0)


def from_begin(probes: Sequence[Probe]) -> tuple[Probe, ...]:
    """Return probes in order of sending, their times from the first one on."""
    ordered = sorted(probes)
    begin_s = ordered[0].sent_s if ordered else 0.0
    return tuple(Probe(probe.sent_s - begin_s, probe.delay_s) for probe in ordered)
