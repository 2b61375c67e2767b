"""Builds the filter node of a scenario."""

from dataclasses import dataclass, replace
from typing import Self

from passafe_protocol.messages import VIRTUAL_CLOCK
from passafe_protocol.validation import MAX_VECTOR

from passafe.filter import SafetyPassivityFilter
from passafe.human_input import HandModel, HumanInputEstimator
from passafe.models.robot import Robot
from passafe.numerics.workspace import Compiler, interpreted
from passafe.override import Explainer
from passafe.state_set import ErrorGrowth
from passafe_services.filter.command_events import CommandEventEmitter
from passafe_services.filter.command_intake import CommandIntake
from passafe_services.filter.command_send_time import CommandSendTime
from passafe_services.filter.dead_man import DeadManFade
from passafe_services.filter.decision_loop import DecisionLoop
from passafe_services.filter.inexact_predictor import InexactPredictor
from passafe_services.filter.input_sequencer import InputSequencer
from passafe_services.filter.model_watch import ModelWatch
from passafe_services.filter.newest_command import NewestCommand
from passafe_services.filter.node import FilterNode
from passafe_services.filter.operator_request import EstimatedRequest, PassThroughRequest
from passafe_services.filter.override_text import OverrideText
from passafe_services.filter.plant_clock import PlantClock
from passafe_services.filter.playout_schedule import PlayoutSchedule
from passafe_services.filter.predictor import Predictor
from passafe_services.filter.resume_ramp import ResumeRamp
from passafe_services.filter.send_time import SendTime
from passafe_services.filter.task_map import command_map
from passafe_services.filter.unpredicted_node import UnpredictedFilterNode
from passafe_services.filter.unpredicted_state import UnpredictedState
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.design import design_of, has_robust_rows, tank_of
from passafe_services.scenarios.info import scenario_info
from passafe_services.scenarios.schema import Scenario, WhiteAccelerationEstimator
from passafe_services.scenarios.uncertain_robot import uncertainty_of


@dataclass(frozen=True, kw_only=True)
class CompiledFilter:
    """Part of a scenario's filter that is expensive to build and has no state.

    Attributes:
        core: The filter.
        explainer: Computes the override of a decision and its causes.
        override_text: Describes an override in a sentence.
        growth: Growth of errors by the scenario's sets; ``None`` without.
    """

    core: SafetyPassivityFilter
    explainer: Explainer
    override_text: OverrideText
    growth: ErrorGrowth | None = None

    @classmethod
    def of(cls, scenario: Scenario, robot: Robot, compiler: Compiler = interpreted) -> Self:
        """Compile the filter of a scenario.

        Args:
            scenario: The scenario.
            robot: Its robot.
            compiler: Compiles what a gatekeeper rolls out.

        Raises:
            DesignError: A part of the design is not valid.
        """
        design = design_of(scenario, robot)
        core = SafetyPassivityFilter(design, compiler=compiler if design.gatekeeper else interpreted)
        sets = uncertainty_of(scenario, robot)
        return cls(
            core=core,
            explainer=Explainer(core),
            override_text=OverrideText(core, robot, scenario.plant.robot_model.input_unit),
            growth=None if sets is None else ErrorGrowth(replace(core.design, uncertainty=sets)),
        )


def filter_node(
    scenario: Scenario,
    driver: str,
    epoch: int,
    model: PlantModel | None = None,
    compiled: CompiledFilter | None = None,
    *,
    clock_id: int = VIRTUAL_CLOCK,
) -> FilterNode | UnpredictedFilterNode:
    """Return the filter node of a scenario, with or without prediction.

    Args:
        scenario: The scenario.
        driver: ``live`` or ``lockstep``, for the log.
        epoch: Session of the filter, the epoch of its messages.
        model: Compiled model of its plant, if there is one already.
        compiled: Compiled filter, if there is one already.
        clock_id: Which monotonic clock the filter's loop reads.
    """
    model = PlantModel.of(scenario) if model is None else model
    compiled = CompiledFilter.of(scenario, model.robot) if compiled is None else compiled
    plant_clock = PlantClock(clock_id, epoch)
    decisions = DecisionLoop(
        compiled.core,
        period_ns=model.period_ns,
        schedule=PlayoutSchedule(period_ns=model.period_ns, playout_ns=model.playout_ns, epoch=epoch),
        commands=CommandIntake(
            request_of(scenario, model.robot.commands, CommandSendTime(clock_id, plant_clock)),
            CommandEventEmitter(round(scenario.operator.stale_s * 1e9), round(scenario.operator.resume_s * 1e9)),
        ),
        command_map=command_map(model.robot),
        plant_clock=plant_clock,
        clock_id=clock_id,
        state_stale_ns=round(scenario.filter.stale_s * 1e9),
        starts_nearest=scenario.filter.start == "nearest",
        explainer=compiled.explainer,
        override_text=compiled.override_text,
        info=scenario_info(scenario, driver),
        watch=None if compiled.growth is None else ModelWatch(compiled.growth),
    )
    tank, period_ns, hold_ns = tank_of(scenario), model.period_ns, model.hold_ns
    if not scenario.filter.prediction:
        return UnpredictedFilterNode(decisions, UnpredictedState(tank), period_ns=period_ns, hold_ns=hold_ns)
    plant = (model.dynamics, model.fail_safe, tank, period_ns)
    growth = compiled.growth if has_robust_rows(scenario) else None
    repeats = min(scenario.filter.repeats, MAX_VECTOR // model.robot.system.m)
    return FilterNode(
        decisions,
        Predictor(*plant) if scenario.is_exact else InexactPredictor(*plant, growth),
        InputSequencer(period_ns=period_ns, hold_ns=hold_ns, repeats=repeats),
    )


def request_of(scenario: Scenario, inputs: int, send_time: SendTime) -> PassThroughRequest:
    """Return the request model of a scenario: pass-through or estimated.

    Args:
        scenario: The scenario.
        inputs: Coordinates of a command.
        send_time: Estimates when commands were sent.

    Raises:
        DesignError: The agility is out of proportion to the resolution.
    """
    operator = scenario.operator
    fade_ns = round(operator.fade_s * 1e9)
    newest = NewestCommand(send_time, round(operator.stale_s * 1e9))
    fade = DeadManFade(inputs, fade_ns)
    ramp = ResumeRamp(DeadManFade(inputs, fade_ns), round(operator.resume_s * 1e9))
    config = operator.estimator
    if not isinstance(config, WhiteAccelerationEstimator):
        return PassThroughRequest(inputs, newest, fade, ramp)
    model = HandModel(**config.model_dump(exclude={"kind"}))
    return EstimatedRequest(inputs, newest, fade, ramp, HumanInputEstimator(model, inputs))
