"""The metrics of one run: those of a review, taken from a loop that is not logged."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantPhase

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.experiment.run_trace import RunTrace
from passafe_services.tools.experiment.tracking import Motion, Tracking
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import PlantEvaluator
from passafe_services.tools.review.properties import Tolerances, judge_driving, judge_properties
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_review import POINTS_PER_PERIOD
from passafe_services.tools.review.steering import Steering
from passafe_services.tools.review.steering_of_log import steering_from
from passafe_services.tools.review.trajectory import Trajectory
from passafe_services.tools.review.verdict import barrier_named
from passafe_services.tools.review.verdict_words import Outcome, decide
from passafe_services.tools.runs.record import SweepRecord

NS_PER_MS: Final = 1e6

LASTS: Final = 0.5
"""Share of a period by which plant time may end before the scenario's duration and still count as all of it."""


class Metrics(SweepRecord):
    """Metrics of one run; ``None`` where there is nothing to take one from. Those that a review has are the review's.

    Attributes:
        duration_s: Plant time from the first sample to the last, s.
        ticks: Filter ticks.
        h_min: Smallest barrier value, at and between samples.
        h_min_barrier: Name of the barrier that it is of.
        h_min_at_samples: The same at samples only.
        tank_min_j: Smallest energy of the tank's ledger, J.
        power_margin_min: Smallest power margin, W, at and between samples.
        power_margin_min_at_samples: The same at samples only.
        u_norm_max: Largest ‖u‖₂ in force.
        held_s: Plant time under an input held beyond its period, s.
        fail_safe_s: Plant time under the plant's own law, s.
        sequence_breaks: How often the plant ran out of inputs and went over to one of these two.
        unserved_share: Share of plant time in one of these two.
        inputs_late: Inputs that came after their time.
        inputs_refused: Inputs that the plant refused.
        guarded_share: Share of the periods whose input the plant's guard has changed.
        input_lead_ms_p50: By how much the newest input came before its time, median over the plant's samples, ms.
        input_lead_ms_min: The same, smallest.
        command_age_ms_p50: Age of the newest command at a filter tick, time on the way included, median, ms.
        command_age_ms_p99: The same, 99th percentile.
        state_age_ms_p50: Age of the newest plant state at a filter tick, time on the way included, median, ms.
        state_age_ms_p99: The same, 99th percentile.
        tracking_rms: Distance from where the robot is at the same time without injected links, root mean square.
        tracking_max: The same, largest.
        final_error: The same, at the end.
        steering: Scores of a simulated person who steered, as ``passafe_services.tools.review.steering`` has them.
        status_counts: Ticks by the filter's status.
        final_x: Last state of the plant.
        properties: Whether each property of a review holds, by name; that of the links' account is of a log.
        verdict: ``holds`` if every required one does, ``fails`` if one does not.
    """

    duration_s: float
    ticks: int
    h_min: float | None
    h_min_barrier: str | None
    h_min_at_samples: float | None
    tank_min_j: float | None
    power_margin_min: float | None
    power_margin_min_at_samples: float | None
    u_norm_max: float | None
    held_s: float
    fail_safe_s: float
    sequence_breaks: int
    unserved_share: float | None
    inputs_late: int
    inputs_refused: int
    guarded_share: float | None = None
    input_lead_ms_p50: float | None
    input_lead_ms_min: float | None
    command_age_ms_p50: float | None
    command_age_ms_p99: float | None
    state_age_ms_p50: float | None
    state_age_ms_p99: float | None
    tracking_rms: float | None
    tracking_max: float | None
    final_error: float | None
    steering: Steering | None
    status_counts: dict[str, int]
    final_x: tuple[float, ...] | None
    properties: dict[str, bool | None]
    verdict: Outcome

    def number(self, name: str) -> float | None:
        """Return one of the metrics that are numbers, by its name in ``NUMERIC``."""
        if name in STEERING:
            return None if self.steering is None else getattr(self.steering, STEERING[name])
        value: float | None = getattr(self, name)
        return value


STEERING: Final = {
    "steering_reached": "reached",
    "steering_time_to_target_s": "time_to_target_s",
    "steering_overshoot": "overshoot",
    "steering_rms_error": "rms_error",
    "steering_effort": "effort",
    "steering_held_back": "held_back",
    "steering_collisions": "collisions",
    "steering_collided_s": "collided_s",
}
"""Scores of ``Steering`` by the names that they have among the metrics."""

NUMERIC: Final = (
    *(
        name
        for name, field in Metrics.model_fields.items()
        if field.annotation in {float, int} or field.annotation == float | None
    ),
    *STEERING,
)
"""Metrics that are numbers: what a criterion may ask about, and what cells are summarised by."""


def metrics_of(
    scenario: Scenario, trace: RunTrace, evaluator: PlantEvaluator, motion: Motion, reference: Tracking | None
) -> Metrics:
    """Return the metrics of a run.

    Args:
        scenario: What was run.
        trace: Trace of the run.
        evaluator: Functions of the scenario.
        motion: Takes the robot's position from its state.
        reference: Where the robot is without injected links, if that is asked for.
    """
    trajectory = trace.trajectory()
    answers = trace.answers()
    passivity = scenario.filter.passivity
    margins = RecomputedMargins.of(
        trajectory, evaluator, passivity, POINTS_PER_PERIOD, answers, is_exact=scenario.is_exact
    )
    phases = trace.phases()
    properties = judge_driving(answers, trace.running_states(), scenario.dt_s)
    properties |= judge_properties(scenario, trace.inputs(), answers, trajectory, margins, Tolerances())
    properties["complete"] = _completeness(scenario, trajectory)
    held_s, fail_safe_s = (_spent_s(phases, phase, trajectory) for phase in (PlantPhase.HOLDING, PlantPhase.FAIL_SAFE))
    moved = trajectory.samples > 0
    duration_s = float(trajectory.t_s[-1] - trajectory.t_s[0]) if moved else 0.0
    lead = _percentiles(trace.input_lead_ns(), 50, 0)
    command_age, state_age = (_percentiles(a[a >= 0], 50, 99) for a in (answers.command_age_ns, answers.state_age_ns))
    deviation = None if reference is None else reference.deviation(motion.of(trajectory))
    return Metrics(
        duration_s=duration_s,
        ticks=answers.status.size,
        h_min=_value(margins.h_min),
        h_min_barrier=barrier_named(scenario, margins.h_min_barrier),
        h_min_at_samples=_value(margins.h_min_at_samples),
        tank_min_j=_value(margins.tank_min_j),
        power_margin_min=_value(margins.power_margin_min),
        power_margin_min_at_samples=_value(margins.power_margin_min_at_samples),
        u_norm_max=_value(margins.u_norm_max),
        held_s=held_s,
        fail_safe_s=fail_safe_s,
        sequence_breaks=_times_begun(phases != PlantPhase.RUNNING),
        unserved_share=(held_s + fail_safe_s) / duration_s if duration_s else None,
        inputs_late=trace.inputs_late,
        inputs_refused=trace.inputs_refused,
        guarded_share=trace.inputs_guarded / trajectory.samples if scenario.has_guard and moved else None,
        input_lead_ms_p50=lead[0],
        input_lead_ms_min=lead[1],
        command_age_ms_p50=command_age[0],
        command_age_ms_p99=command_age[1],
        state_age_ms_p50=state_age[0],
        state_age_ms_p99=state_age[1],
        tracking_rms=None if deviation is None else deviation.rms,
        tracking_max=None if deviation is None else deviation.largest,
        final_error=None if deviation is None else deviation.final,
        steering=steering_from(scenario, trajectory, evaluator, trace.requests()),
        status_counts=answers.counts,
        final_x=tuple(trajectory.x[:, -1].tolist()) if moved else None,
        properties={name: entry.holds for name, entry in properties.items()},
        verdict=decide(properties),
    )


def _completeness(scenario: Scenario, trajectory: Trajectory) -> Property:
    """Judge whether the run lasted as long as the scenario: without an input the plant never begins to move."""
    missing_s = scenario.duration_s - (float(trajectory.t_s[-1]) if trajectory.samples else 0.0)
    return Property(
        holds=missing_s <= LASTS * scenario.dt_s,
        required=True,
        worst=max(missing_s, 0.0),
        at_s=None,
        requirement="plant time missing until the scenario's duration, s, = 0",
        allowed="= 0",
    )


def _spent_s(phases: IntArray, phase: PlantPhase, trajectory: Trajectory) -> float:
    return float(trajectory.period_s[phases == phase].sum())


def _times_begun(during: NDArray[np.bool_]) -> int:
    """Return how many stretches of samples there are in which something is so."""
    return int(np.count_nonzero(during & ~np.concatenate(([False], during[:-1]))))


def _percentiles(durations_ns: IntArray, *which: float) -> tuple[float | None, ...]:
    """Return percentiles in ms, interpolated linearly."""
    if durations_ns.size == 0:
        return (None,) * len(which)
    return tuple((np.percentile(durations_ns, which) / NS_PER_MS).tolist())


def _value(extremum: Extremum | None) -> float | None:
    return None if extremum is None else extremum.value
