"""From a scenario to the nodes of its loop: the same ones live and in lockstep."""

from passafe.filter import SafetyPassivityFilter
from passafe.human_input import HandModel, HumanInputEstimator
from passafe.models.robot import Robot
from protocol.validation import MAX_VECTOR
from services.arming.fail_safe import FailSafe
from services.filter.arming import Arming, Loose
from services.filter.node import FilterNode
from services.filter.prediction import NoPrediction, Predictor
from services.filter.request import AsSent, Estimated
from services.filter.schedule import EffectSchedule
from services.filter.wording import Wording
from services.operator.node import OperatorNode
from services.operator.scenario_source import source_of
from services.plant.node import PlantNode
from services.runtime.lockstep import Lockstep, Observer
from services.scenarios.design import design_of, limits_of, robot_of, sampled_plant_of, tank_of
from services.scenarios.info import scenario_info
from services.scenarios.links import link_changes, link_settings
from services.scenarios.schema import Scenario, WhiteAccelerationEstimator
from services.scenarios.units import input_unit

VIRTUAL_WALL_NS = 1_000_000_000_000_000_000
"""Wall clock minus virtual clock of a lockstep run: a fixed day in 2001, so that logs show it and stay the same."""


def period_ns(scenario: Scenario) -> int:
    """Return the period of one tick, ns."""
    return round(1e9 / scenario.rate_hz)


def plant_node(scenario: Scenario) -> PlantNode:
    """Return the plant of a scenario."""
    robot = robot_of(scenario)
    return PlantNode(
        sampled_plant_of(scenario, robot),
        fail_safe_of(scenario, robot),
        x0=scenario.plant.x0,
        period_ns=period_ns(scenario),
        playout_ns=_whole_periods(scenario.plant.playout_s, scenario),
        limits=limits_of(scenario, robot),
    )


def fail_safe_of(scenario: Scenario, robot: Robot) -> FailSafe:
    """Return what is in force at the scenario's plant where no input follows."""
    hold_ns = round(scenario.plant.hold_s * 1e9)
    return FailSafe(robot, limits_of(scenario, robot), period_ns=period_ns(scenario), hold_ns=hold_ns)


def filter_node(scenario: Scenario, driver: str, epoch: int) -> FilterNode:
    """Return the filter of a scenario.

    Args:
        scenario: What to build.
        driver: ``live`` or ``lockstep``, for the log.
        epoch: Its session, as the driver stamps it on what it sends.
    """
    robot = robot_of(scenario)
    core = SafetyPassivityFilter(design_of(scenario, robot))
    tick_ns = period_ns(scenario)
    foresight, series = _foresight_of(scenario, robot)
    return FilterNode(
        core,
        period_ns=tick_ns,
        foresight=foresight,
        series=series,
        schedule=EffectSchedule(
            period_ns=tick_ns, playout_ns=_whole_periods(scenario.plant.playout_s, scenario), epoch=epoch
        ),
        request=request_of(scenario, robot.system.m),
        state_stale_ns=round(scenario.filter.stale_s * 1e9),
        starts_nearest=scenario.filter.start == "nearest",
        wording=Wording(core, robot, input_unit(scenario)),
        info=scenario_info(scenario, driver),
    )


def _foresight_of(scenario: Scenario, robot: Robot) -> tuple[Predictor | NoPrediction, Arming | Loose]:
    """Return what tells the state for which an input is made, and how inputs are sent."""
    tick_ns, hold_ns = period_ns(scenario), round(scenario.plant.hold_s * 1e9)
    tank = tank_of(scenario)
    if not scenario.filter.prediction:
        return NoPrediction(tank), Loose(period_ns=tick_ns, hold_ns=hold_ns)
    repeats = min(scenario.filter.repeats, MAX_VECTOR // robot.system.m)
    predictor = Predictor(sampled_plant_of(scenario, robot), fail_safe_of(scenario, robot), tank, tick_ns)
    return predictor, Arming(period_ns=tick_ns, hold_ns=hold_ns, repeats=repeats)


def request_of(scenario: Scenario, inputs: int) -> AsSent:
    """Return how the scenario's filter reads the operator's commands.

    Raises:
        DesignError: An agility out of proportion to the resolution.
    """
    stale_ns, fade_ns = round(scenario.operator.stale_s * 1e9), round(scenario.operator.fade_s * 1e9)
    config = scenario.operator.estimator
    if not isinstance(config, WhiteAccelerationEstimator):
        return AsSent(inputs, stale_ns, fade_ns)
    model = HandModel(**config.model_dump(exclude={"kind"}))
    return Estimated(inputs, stale_ns, fade_ns, HumanInputEstimator(model, inputs))


def operator_node(scenario: Scenario, epoch: int) -> OperatorNode:
    """Return the operator of a scenario, script or simulated person, its session stamped with ``epoch``."""
    return OperatorNode(source_of(scenario), epoch=epoch)


def _whole_periods(duration_s: float, scenario: Scenario) -> int:
    return round(duration_s * scenario.rate_hz) * period_ns(scenario)


def steps_of(scenario: Scenario) -> int:
    """Return the steps of a lockstep run that covers the scenario's duration of plant time without delay."""
    return round(scenario.duration_s * scenario.rate_hz) + round(scenario.plant.playout_s * scenario.rate_hz) + 1


def lockstep_loop(scenario: Scenario, observer: Observer | None = None) -> Lockstep:
    """Return the whole loop of a scenario in virtual time.

    Args:
        scenario: What to run.
        observer: Called with every message, see ``Lockstep``.
    """
    epoch = 1
    return Lockstep(
        [plant_node(scenario), operator_node(scenario, epoch), filter_node(scenario, "lockstep", epoch)],
        period_ns=period_ns(scenario),
        links=link_settings(scenario),
        link_changes=link_changes(scenario),
        wall_offset_ns=VIRTUAL_WALL_NS,
        epoch=epoch,
        observer=observer,
    )
