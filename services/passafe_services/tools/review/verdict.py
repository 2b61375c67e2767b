"""Verdict on one run, as printed by ``passafe review --json``."""

from typing import Final, Self

from passafe_protocol.messages import PlantState
from passafe_protocol.topics import COMMAND, STATE, TICK
from pydantic import BaseModel, ConfigDict

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.command_use import CommandUse
from passafe_services.tools.review.errors import MismatchedLogError
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.guard_record import GuardAccount
from passafe_services.tools.review.judged_properties import ReadLog, judged_properties
from passafe_services.tools.review.link_accounts import LinkAccount
from passafe_services.tools.review.plant_evaluator import PlantEvaluator
from passafe_services.tools.review.properties import Tolerances
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_identity import DriverName
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.run_review import POINTS_PER_PERIOD, RunReview
from passafe_services.tools.review.steering import Steering
from passafe_services.tools.review.timing import Percentiles, Timing
from passafe_services.tools.review.trajectory import Trajectory
from passafe_services.tools.review.verdict_words import Outcome, decide, in_words

CONTROL_LOOP: Final = {"operator": COMMAND, "filter": TICK, "plant": STATE}
"""Topic that each process of the loop publishes in every step."""


class Verdict(BaseModel):
    """Result of the review of one log; values that the log does not contain are ``None``.

    ``h_min`` and ``power_margin_min`` are recomputed from the plant's states and the inputs in force, at every sample
    and at ``points_per_period`` instants between samples; filter telemetry is not trusted for them.

    Attributes:
        scenario: Name of the scenario.
        mode: Mode of the filter: off, safe, passive or both.
        law: Law of the filter: sampled or continuous.
        driver: Driver of the nodes: live or lockstep.
        finished: Whether the log is complete.
        duration_s: Plant time from the first sample to the last, s.
        ticks: Filter ticks in the log.
        steps_skipped: Filter steps skipped to catch up.
        sessions: Sessions of operator, filter and plant; more than one after restarts.
        sequence_breaks: Number of sequence breaks.
        without_input_s: Total plant time without input, s.
        received: Distinct messages in the log, by topic.
        gaps: Messages missing between others, by topic.
        missed_at_start: Messages missing before the first one, by topic.
        undecodable: Messages in the log that are not valid for their topic, by topic.
        h_min: Smallest barrier value.
        h_min_barrier: Name of its barrier.
        h_min_at_samples: Smallest barrier value at samples only.
        power_margin_min: Smallest power margin h_u(x, u), W.
        power_margin_min_at_samples: Smallest power margin at samples only, W.
        tank_min_j: Smallest energy of the tank, J, at samples and between them.
        u_norm_max: Largest ‖u‖₂ in force.
        status_counts: Number of ticks by status of the filter.
        solve_us_p50: Time from the beginning of a filter step until its input is sent, decoding and certificate
            included; median, µs; live logs only.
        solve_us_p99: The same, 99th percentile, µs.
        late_us_p50: Lateness of filter steps, median, µs; live logs only.
        late_us_p99: The same, 99th percentile, µs.
        command_age_ms_p50: Age of the newest operator command at a filter tick, median, ms.
        command_age_ms_p99: The same, 99th percentile, ms.
        commands: Share of the ticks in which the operator's command counted, and why not in the others.
        timing: Further percentiles, of every process and of the latency from operator to plant.
        final_x: Last state of the plant.
        steering: Steering metrics; ``None`` without a simulated person.
        guard: What the guard at the plant did; ``None`` without one.
        links: Account of every link, by session of its reader.
        points_per_period: Instants evaluated in every period, besides the samples.
        tolerances: Tolerances of the recomputed values.
        properties: Properties of the run, by name.
        verdict: ``holds`` if every required property holds; ``fails`` if the log shows that one does not;
            ``unproven`` if it shows none that fails, but not the whole run either.
        words: The same in a sentence, with what stands against it: fallbacks first.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: str
    mode: str
    law: str
    driver: DriverName
    finished: bool
    duration_s: float
    ticks: int
    steps_skipped: int
    sessions: dict[str, int]
    sequence_breaks: int
    without_input_s: float
    received: dict[str, int]
    gaps: dict[str, int]
    missed_at_start: dict[str, int]
    undecodable: dict[str, int]
    h_min: float | None
    h_min_barrier: str | None
    h_min_at_samples: float | None
    power_margin_min: float | None
    power_margin_min_at_samples: float | None
    tank_min_j: float | None
    u_norm_max: float | None
    status_counts: dict[str, int]
    solve_us_p50: float | None
    solve_us_p99: float | None
    late_us_p50: float | None
    late_us_p99: float | None
    command_age_ms_p50: float | None
    command_age_ms_p99: float | None
    commands: CommandUse
    timing: Timing
    final_x: tuple[float, ...] | None
    steering: Steering | None
    guard: GuardAccount | None
    links: list[LinkAccount]
    points_per_period: int
    tolerances: Tolerances
    properties: dict[str, Property]
    verdict: Outcome
    words: str

    @classmethod
    def of(
        cls,
        log: RunLog,
        evaluator: PlantEvaluator,
        *,
        tolerances: Tolerances | None = None,
        points_per_period: int = POINTS_PER_PERIOD,
        derives: bool = True,
    ) -> Self:
        """Judge a run.

        Args:
            log: Its log.
            evaluator: Functions of the log's scenario.
            tolerances: Tolerances of the recomputed values; the defaults if not given.
            points_per_period: Instants to evaluate per period, its end included.
            derives: Whether to derive anew what processes of passafe report, and compare.

        Raises:
            MismatchedLogError: The states in the log do not have the dimension of the scenario.
        """
        review = RunReview(
            log.path,
            log.identity,
            evaluator,
            tolerances=tolerances,
            points_per_period=points_per_period,
            derives=derives,
        )
        for part in log.slices(review.wants):
            review.take(part)
        return cls.concluding(review, log)

    @classmethod
    def concluding(cls, review: RunReview, log: ReadLog) -> Self:
        """Return the verdict at the end of a review; nothing more may be taken by it.

        Args:
            review: The review, which has taken the whole log.
            log: The log, read to its end.
        """
        plant, decisions, scenario = review.plant, review.decisions, review.identity.scenario
        plant.finish()
        margins = RecomputedMargins(**review.margins.extrema())
        accounts = review.links.accounts()
        properties = judged_properties(review, log, margins, accounts)
        timing = review.timing.timing()
        solve_us_p50, solve_us_p99 = _percentiles(timing.solve_us)
        late_us_p50, late_us_p99 = _percentiles((timing.late_us or {}).get("filter"))
        command_age_ms_p50, command_age_ms_p99 = _percentiles(timing.command_age_ms)
        sessions = [*plant.sessions.values()]
        return cls(
            scenario=scenario.name,
            mode=scenario.filter.mode,
            law=scenario.filter.law,
            driver=review.identity.driver,
            finished=log.finished,
            duration_s=plant.duration_s,
            ticks=decisions.ticks,
            steps_skipped=review.timing.steps_skipped,
            sessions={process: log.counts[topic.name].sessions for process, topic in CONTROL_LOOP.items()},
            sequence_breaks=sum(len(session.breaks.breaks()) for session in sessions),
            without_input_s=sum(session.breaks.without_input_s for session in sessions),
            received={name: count.received for name, count in log.counts.items()},
            gaps={name: count.gaps for name, count in log.counts.items()},
            missed_at_start={name: count.missed_at_start for name, count in log.counts.items()},
            undecodable={name: count.undecodable for name, count in log.counts.items()},
            h_min=_value(margins.h_min),
            h_min_barrier=barrier_named(scenario, margins.h_min_barrier),
            h_min_at_samples=_value(margins.h_min_at_samples),
            power_margin_min=_value(margins.power_margin_min),
            power_margin_min_at_samples=_value(margins.power_margin_min_at_samples),
            tank_min_j=_value(margins.tank_min_j),
            u_norm_max=_value(margins.u_norm_max),
            status_counts=decisions.status_counts,
            solve_us_p50=solve_us_p50,
            solve_us_p99=solve_us_p99,
            late_us_p50=late_us_p50,
            late_us_p99=late_us_p99,
            command_age_ms_p50=command_age_ms_p50,
            command_age_ms_p99=command_age_ms_p99,
            commands=decisions.commands,
            timing=timing,
            final_x=plant.final_x,
            steering=None if review.steering is None else review.steering.result(),
            guard=review.guard.account(),
            links=accounts,
            points_per_period=review.points_per_period,
            tolerances=review.tolerances,
            properties=properties,
            verdict=decide(properties),
            words=in_words(properties),
        )


def trajectory_of(log: RunLog) -> Trajectory:
    """Return the trajectory of the plant in a log.

    Raises:
        MismatchedLogError: The states do not have the dimension of the scenario.
    """
    states = log.of(PlantState)
    allowed = len(log.identity.scenario.plant.x0)
    for state in states:
        if len(state.body.x) != allowed:
            where = f"state {state.header.sequence}"
            got = f"{len(state.body.x)} numbers, allowed {allowed} as in the scenario"
            raise MismatchedLogError(log.path, f"{where}: got {got}")
    return Trajectory.of(states)


def barrier_named(scenario: Scenario, number: int | None) -> str | None:
    """Return the name of a barrier of a scenario by its index in the file."""
    return None if number is None else scenario.barriers[number].name


def _value(extremum: Extremum | None) -> float | None:
    return None if extremum is None else extremum.value


def _percentiles(spread: Percentiles | None) -> tuple[float | None, float | None]:
    return (None, None) if spread is None else (spread.p50, spread.p99)
