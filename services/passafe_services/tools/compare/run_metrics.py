"""Metrics of one run that a comparison sets side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from passafe_protocol.messages import FilterTick
from pydantic import BaseModel, ConfigDict

from passafe_services.scenarios.design import robot_of
from passafe_services.tools.experiment.tracking import Motion, Tracking
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict, trajectory_of

NS_PER_MS: Final = 1e6


class RunMetrics(BaseModel):
    """Metrics of one run; ``None`` where its log has nothing to take one from.

    Attributes:
        log: Path of the log.
        scenario: Name of the scenario.
        mode: Mode of the filter.
        verdict: Verdict of the review.
        words: The same in a sentence.
        duration_s: Plant time, s.
        ticks: Ticks of the filter.
        h_min: Smallest barrier value, also between samples.
        power_margin_min: Smallest power margin, W, likewise.
        tank_min_j: Smallest energy of the tank, J.
        u_norm_max: Largest ‖u‖ in force.
        state_age_ms_p50: Age of the newest state at a tick, median, ms.
        state_age_ms_p99: The same, 99th percentile.
        command_age_ms_p50: Age of the newest command at a tick, median, ms.
        command_age_ms_p99: The same, 99th percentile.
        overridden_share: Share of the ticks in which some of the operator's input was held back.
        held_back_share: ∫‖held back‖ dt over ∫‖u_h‖ dt: how much of what the operator asked for was withheld.
        time_to_target_s: Longest settling time at the targets of a simulated person, s.
        steering_rms_error: Root mean square of its distance from the targets.
        status_counts: Ticks by the filter's status.
        final_x: Last state of the plant.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    log: str
    scenario: str
    mode: str
    verdict: str
    words: str
    duration_s: float
    ticks: int
    h_min: float | None
    power_margin_min: float | None
    tank_min_j: float | None
    u_norm_max: float | None
    state_age_ms_p50: float | None
    state_age_ms_p99: float | None
    command_age_ms_p50: float | None
    command_age_ms_p99: float | None
    overridden_share: float | None
    held_back_share: float | None
    time_to_target_s: float | None
    steering_rms_error: float | None
    status_counts: dict[str, int]
    final_x: tuple[float, ...] | None


NUMERIC: Final = tuple(
    name for name, field in RunMetrics.model_fields.items() if field.annotation in {float, int, float | None}
)
"""Metrics that are numbers."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReviewedRun:
    """A log with what its review found.

    Attributes:
        log: The log.
        metrics: Its metrics.
        motion: Position of the robot over plant time.
        verdict: Verdict of the review.
    """

    log: RunLog
    metrics: RunMetrics
    motion: Tracking
    verdict: Verdict

    @classmethod
    def of(cls, log: RunLog) -> Self:
        """Review a log.

        Raises:
            MismatchedLogError: The states in the log do not have the dimension of the scenario.
        """
        scenario = log.identity.scenario
        verdict = Verdict.of(log, CoreEvaluator(scenario))
        return cls(
            log=log,
            metrics=_metrics(log, verdict),
            motion=Motion(robot_of(scenario)).of(trajectory_of(log)),
            verdict=verdict,
        )


def _metrics(log: RunLog, verdict: Verdict) -> RunMetrics:
    ticks = [tick.body for tick in log.of(FilterTick)]
    steering = verdict.steering
    state_age = _ages_ms([tick.state_age_ns for tick in ticks])
    command_age = _ages_ms([tick.command_age_ns for tick in ticks])
    overridden, held_back = _overrides(ticks)
    return RunMetrics(
        log=str(log.path),
        scenario=verdict.scenario,
        mode=verdict.mode,
        verdict=verdict.verdict,
        words=verdict.words,
        duration_s=verdict.duration_s,
        ticks=verdict.ticks,
        h_min=verdict.h_min,
        power_margin_min=verdict.power_margin_min,
        tank_min_j=verdict.tank_min_j,
        u_norm_max=verdict.u_norm_max,
        state_age_ms_p50=state_age[0],
        state_age_ms_p99=state_age[1],
        command_age_ms_p50=command_age[0],
        command_age_ms_p99=command_age[1],
        overridden_share=overridden,
        held_back_share=held_back,
        time_to_target_s=None if steering is None else steering.time_to_target_s,
        steering_rms_error=None if steering is None else steering.rms_error,
        status_counts=verdict.status_counts,
        final_x=verdict.final_x,
    )


def _ages_ms(ages_ns: Sequence[int]) -> tuple[float | None, float | None]:
    """Return median and 99th percentile; −1 stands for no message yet."""
    known = np.array([age for age in ages_ns if age >= 0], dtype=np.float64)
    if not known.size:
        return None, None
    median, high = (np.percentile(known, (50, 99)) / NS_PER_MS).tolist()
    return median, high


def _overrides(ticks: Sequence[FilterTick]) -> tuple[float | None, float | None]:
    """Return the share of ticks with an override, and what it withheld of all that was asked for."""
    if not ticks:
        return None, None
    held = np.array([np.linalg.norm(tick.override.held_back) for tick in ticks])
    asked = float(np.sum([np.linalg.norm(tick.u_h) for tick in ticks]))
    return float(np.mean(held > 0)), float(held.sum()) / asked if asked else None
