"""Comparison of runs with the first of them: metrics, their differences, and how far the robots are apart."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe_services.tools.compare.alignment import origin_s
from passafe_services.tools.compare.run_metrics import NUMERIC, ReviewedRun, RunMetrics
from passafe_services.tools.experiment.tracking import Tracking


class Apart(BaseModel):
    """Distance of a robot from where that of the first run is at the same aligned time.

    Attributes:
        rms: Root mean square over the times that both have.
        largest: Largest.
        largest_at_s: Aligned time of the largest, s.
        final: At the last of these times.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    rms: float
    largest: float
    largest_at_s: float
    final: float


class ComparedRun(BaseModel):
    """One run beside the first one.

    Attributes:
        metrics: Its metrics.
        origin_s: Plant time that counts as zero, s.
        differences: Its metrics minus those of the first run, where both have them.
        apart: Distance of the robots; ``None`` for the first run, and where they have no time in common.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    metrics: RunMetrics
    origin_s: float
    differences: dict[str, float]
    apart: Apart | None


class Comparison(BaseModel):
    """Runs side by side, as ``passafe compare --json`` prints them.

    Attributes:
        align: What was aligned.
        runs: The runs, in the order given.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    align: str
    runs: tuple[ComparedRun, ...]

    @classmethod
    def of(cls, runs: Sequence[ReviewedRun], align: str = "start") -> Self:
        """Compare runs with the first of them.

        Args:
            runs: At least one.
            align: See ``alignment.origin_s``.

        Raises:
            AlignmentError: They cannot be aligned so.
        """
        origins = [origin_s(run.log, align) for run in runs]
        first = runs[0]
        compared = [
            ComparedRun(
                metrics=run.metrics,
                origin_s=origin,
                differences=_differences(first.metrics, run.metrics),
                apart=None if run is first else apart(_shifted(first.motion, origins[0]), _shifted(run.motion, origin)),
            )
            for run, origin in zip(runs, origins, strict=True)
        ]
        return cls(align=align, runs=tuple(compared))


def apart(first: Tracking, other: Tracking) -> Apart | None:
    """Return how far two robots are apart, interpolated to the times of the first; ``None`` without common times."""
    if not first.t_s.size or not other.t_s.size or first.position.shape[0] != other.position.shape[0]:
        return None
    both = (first.t_s >= other.t_s[0]) & (first.t_s <= other.t_s[-1])
    if not both.any():
        return None
    t_s = first.t_s[both]
    there = np.array([np.interp(t_s, other.t_s, row) for row in other.position])
    distance = np.linalg.norm(first.position[:, both] - there, axis=0)
    worst = int(distance.argmax())
    return Apart(
        rms=float(np.sqrt(np.mean(distance**2))),
        largest=float(distance[worst]),
        largest_at_s=float(t_s[worst]),
        final=float(distance[-1]),
    )


def _shifted(motion: Tracking, origin: float) -> Tracking:
    """Return a motion over aligned time, of the last session of its plant."""
    rising = np.diff(motion.t_s, prepend=-np.inf) > 0
    begins = int(np.flatnonzero(~rising)[-1]) if not rising.all() else 0
    return Tracking(t_s=motion.t_s[begins:] - origin, position=motion.position[:, begins:])


def _differences(first: RunMetrics, other: RunMetrics) -> dict[str, float]:
    found = {}
    for name in NUMERIC:
        before, after = getattr(first, name), getattr(other, name)
        if before is not None and after is not None:
            found[name] = after - before
    return found
