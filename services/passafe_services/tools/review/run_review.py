"""Review of a run in one pass over its log; the verdict is what it ends with."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from passafe_protocol.messages import PlantPhase, ScenarioInfo
from passafe_protocol.topics import INPUT, STATE, TICK

from passafe.state_set import ErrorGrowth
from passafe_services.filter.decision_loop import MOST_AT_ONCE
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogConsumer, LogPass, LogSlice
from passafe_services.log.log_writer import SCENARIO_RECORD
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.scenarios.uncertain_robot import reading_error_of, uncertainty_of
from passafe_services.tools.review.between_samples import MarginsInProgress
from passafe_services.tools.review.consumption_check import ConsumptionCheck
from passafe_services.tools.review.decision_check import DecisionCheck
from passafe_services.tools.review.decision_record import DecisionRecord
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.filter_claims import SentInputs
from passafe_services.tools.review.guard_record import GuardRecord
from passafe_services.tools.review.input_agreement import InputAgreement
from passafe_services.tools.review.input_limits import InputLimitRecord
from passafe_services.tools.review.input_origin import OriginRecord
from passafe_services.tools.review.link_accounts import LinkRecord
from passafe_services.tools.review.model_check import ModelCheck
from passafe_services.tools.review.plant_evaluator import PlantEvaluator
from passafe_services.tools.review.plant_record import PlantReview
from passafe_services.tools.review.properties import Tolerances
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_identity import RunIdentity, identify
from passafe_services.tools.review.scenario_check import ScenarioCheck
from passafe_services.tools.review.sent_inputs import SentInputCheck
from passafe_services.tools.review.state_check import StateCheck
from passafe_services.tools.review.state_reports import StateReportCheck
from passafe_services.tools.review.steering_in_progress import SteeringInProgress
from passafe_services.tools.review.tank_check import TankCheck
from passafe_services.tools.review.timing import TimingRecord
from passafe_services.tools.review.trajectory import NS_PER_S

POINTS_PER_PERIOD: Final = 10
"""Instants evaluated in every period, besides the samples."""

_STEERING: Final[Wants] = {STATE.name: ("plant_ns", "x", "phase"), TICK.name: ("u_h", "u_nominal", "u")}
_SENT: Final[Wants] = {INPUT.name: ("u", "effective_plant_ns", "input_sequence_start_ns")}


class RunReview:
    """Review of a run in progress: a consumer of a pass over its log.

    Args:
        path: The log, for errors.
        identity: Scenario and driver of the run.
        evaluator: Functions of the scenario.
        tolerances: Tolerances of the recomputed values; the defaults if not given.
        points_per_period: Instants to evaluate per period, its end included.
        derives: Whether to derive anew what processes of passafe report, and compare.

    Attributes:
        wants: Columns that it reads.
        margins: Extrema of the motion.
        drive: What moved the robot.
        decisions: Ticks of the filter.
        plant: States of the plant.
        limits: Inputs beside their limits.
        origin: Who decided the inputs in force.
        states: States beside the model.
        reports: What states report besides.
        inputs: Inputs sent beside those decided.
        sent: What inputs say besides.
        derived: Decisions beside those derived anew.
        consumed: Ticks beside the messages that they consumed.
        tank: The filter's tank beside what its inputs give.
        configuration: Configurations beside one another.
        model: States beside what the scenario's sets allow.
        guard: What the guard at the plant did.
        timing: Times of the processes.
        links: Accounts of the links.
        steering: Metrics of a simulated person; ``None`` without one.
    """

    def __init__(
        self,
        path: Path,
        identity: RunIdentity,
        evaluator: PlantEvaluator,
        *,
        tolerances: Tolerances | None = None,
        points_per_period: int = POINTS_PER_PERIOD,
        derives: bool = True,
    ) -> None:
        scenario = identity.scenario
        self.identity = identity
        self.tolerances = tolerances or Tolerances()
        self.points_per_period = points_per_period
        self._evaluator = evaluator
        robot = robot_of(scenario)
        self._m = robot.system.m
        period_ns = scenario.dt_s * NS_PER_S
        self.margins = MarginsInProgress(
            evaluator,
            scenario.filter.passivity,
            points_per_period,
            is_exact=scenario.is_exact,
            reading_error=np.array(reading_error_of(scenario, robot)),
        )
        self.drive = DriveRecord()
        self.decisions = DecisionRecord(round(period_ns), self.tolerances.certificate, self.margins.energy, self.drive)
        self.states = StateCheck(evaluator, is_exact=scenario.is_exact)
        self.reports = StateReportCheck(scenario, self.states.agreement)
        self.plant = PlantReview(
            path, len(scenario.plant.x0), self._m, scenario.dt_s, self.margins, self.drive, self.states
        )
        self.limits = InputLimitRecord(scenario, self.tolerances.input_relative)
        self.origin = OriginRecord(
            len(scenario.plant.x0), is_predicted=scenario.filter.prediction and scenario.is_exact
        )
        self.inputs = InputAgreement(self._m)
        self.sent = SentInputCheck(scenario, self._m, self.inputs.agreement)
        self.derived = DecisionCheck(scenario)
        self.consumed = ConsumptionCheck(scenario)
        self.tank = TankCheck(
            evaluator,
            scenario.filter.passivity,
            period_s=scenario.dt_s,
            n=len(scenario.plant.x0),
            m=self._m,
        )
        self.configuration = ScenarioCheck(identity)
        self.model = ModelCheck(growth_of(scenario), len(scenario.plant.x0), self._m)
        self.guard = GuardRecord()
        self.timing = TimingRecord(is_live=identity.driver == "live", period_ns=period_ns)
        self.links = LinkRecord(scenario, is_live=identity.driver == "live")
        person = scenario.operator.source
        self.steering = SteeringInProgress(person) if isinstance(person, HumanSource) else None
        self._steered: int | None = None
        self._parts: Sequence[LogConsumer] = (
            *(self.decisions, self.plant, self.origin, self.timing, self.links, self.model, self.guard),
            *(
                (self.reports, self.inputs, self.sent, self.derived, self.consumed, self.configuration)
                if derives
                else ()
            ),
            *((self.tank,) if derives and scenario.is_exact else ()),
        )
        self.derives = derives
        self.wants = merged(*(part.wants for part in self._parts), _SENT, *([_STEERING] if self.steering else []))

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for consumer in self._parts:
            consumer.take(part)
        for block in part.blocks(INPUT.name):
            self.limits.take_sent(SentInputs.in_block(block, self._m), session=block.session)
        for block in part.blocks(STATE.name):
            moves = block.numbers("phase") != PlantPhase.WAITING
            u = block.matrix("u", self._m)[:, moves]
            self.limits.take_applied(u, block.numbers("plant_ns")[moves] / NS_PER_S)
        if self.steering is not None:
            self._steer(part, self.steering)

    def assumption(self) -> dict[str, Property]:
        """Return the property that the robot is in the scenario's sets, by name; nothing without sets."""
        return {} if self.identity.scenario.uncertainty is None else {"model": self.model.property()}

    def agreement(self) -> dict[str, Property]:
        """Return the properties that what processes report agrees with what is derived anew, by name."""
        if not self.derives:
            return {}
        scenario = self.identity.scenario
        return {
            "states-agree": self.states.agreement.property(),
            "inputs-agree": self.inputs.finish(MOST_AT_ONCE if self.identity.driver == "live" else 0).property(),
            "predictions-agree": self.origin.agreement.property(
                required=scenario.filter.prediction and scenario.is_exact
            ),
            "decisions-agree": self.derived.agreement.property(),
            "ticks-agree": self.consumed.finish().property(),
            "tank-agrees": self.tank.agreement.property(required=scenario.filter.prediction and scenario.is_exact),
            "scenario-agrees": self.configuration.property(is_published=self.decisions.ticks > 0),
        }

    def _steer(self, part: LogSlice, steering: SteeringInProgress) -> None:
        for block in part.blocks(TICK.name):
            u_h, nominal, u = (block.ragged(path) for path in ("u_h", "u_nominal", "u"))
            known = (u_h.counts == self._m) & (nominal.counts == self._m) & (u.counts == self._m)
            rows = np.flatnonzero(known)
            requested, asked, sent = (column.take(rows).matrix(self._m).T for column in (u_h, nominal, u))
            steering.take_ticks(block.numbers("effective_plant_ns")[rows], requested, asked - sent)
        for block in part.blocks(STATE.name):
            if block.session != self._steered:
                self._steered = block.session
                steering.restart()
            moves = block.numbers("phase") != PlantPhase.WAITING
            if moves.any():
                t_s = np.asarray(block.numbers("plant_ns")[moves] / NS_PER_S, dtype=np.float64)
                x = block.matrix("x", len(self.identity.scenario.plant.x0))[:, moves]
                steering.take_states(t_s, x[: steering.axes], self._evaluator.h(x, t_s))


def growth_of(scenario: Scenario) -> ErrorGrowth | None:
    """Return the growth of errors by a scenario's sets; ``None`` without.

    Raises:
        ScenarioError: Sets that do not fit the robot.
        DesignError: A design that cannot have sets.
    """
    robot = robot_of(scenario)
    sets = uncertainty_of(scenario, robot)
    return None if sets is None else ErrorGrowth(replace(design_of(scenario, robot), uncertainty=sets))


def merged(*wants: Wants) -> Wants:
    """Return everything that any of several consumers wants."""
    together: dict[str, set[str]] = {}
    for one in wants:
        for name, paths in one.items():
            together.setdefault(name, set()).update(paths)
    return together


def identity_of(run: LogPass) -> RunIdentity:
    """Return the identity of the run in a log, from its beginning.

    Raises:
        ForeignLogError: The log has no channel of passafe.
        ScenarioRecordError: It does not say which scenario it is of, or this build cannot read that.
    """
    if SCENARIO_RECORD in run.metadata:
        return identify(run.path, run.metadata, None)
    first = next(LogPass(run.path, workers=0).messages(ScenarioInfo), None)
    return identify(run.path, run.metadata, None if first is None else first.body)
