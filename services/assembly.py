"""From a scenario to the nodes of its loop: the same ones live and in lockstep."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from passafe.filter import SafetyPassivityFilter
from passafe.human_input import HandModel, HumanInputEstimator
from passafe.models.robot import Robot
from passafe.override import Explainer
from passafe.sampled_plant import SampledPlant
from protocol.topics import Topic
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
from services.runtime.lockstep import Lockstep, Observer, Tap
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


@dataclass(frozen=True, kw_only=True)
class Derived:
    """What a scenario's plant and filter are derived into: the part of its nodes that takes time and has no memory.

    Loops that run one after the other may share it, however their links, starts, operators and times differ, as long
    as ``key_of`` is the same for their scenarios.

    Attributes:
        robot: The robot.
        core: Its filter.
        plant: Its model, stepped at the scenario's rate.
        fail_safe: What is in force at the plant where no input follows.
        explainer: Tells what the filter overrides and why.
        wording: Puts what the filter overrides into words.
    """

    robot: Robot
    core: SafetyPassivityFilter
    plant: SampledPlant
    fail_safe: FailSafe
    explainer: Explainer
    wording: Wording

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Derive them.

        Raises:
            ScenarioError: The model does not take its parameters or x0.
            DesignError: Some part of the design cannot be used.
        """
        robot = robot_of(scenario)
        core = SafetyPassivityFilter(design_of(scenario, robot))
        return cls(
            robot=robot,
            core=core,
            plant=sampled_plant_of(scenario, robot),
            fail_safe=FailSafe(
                robot,
                limits_of(scenario, robot),
                period_ns=period_ns(scenario),
                hold_ns=round(scenario.plant.hold_s * 1e9),
            ),
            explainer=Explainer(core),
            wording=Wording(core, robot, input_unit(scenario)),
        )

    @staticmethod
    def key_of(scenario: Scenario) -> str:
        """Return what of a scenario is derived from, as text."""
        plant = {"model", "parameters", "hold_s"}
        part = scenario.model_dump_json(include={"name": True, "rate_hz": True, "plant": plant, "filter": True})
        return f"{len(scenario.plant.x0)} {part}"


def plant_node(scenario: Scenario, derived: Derived | None = None) -> PlantNode:
    """Return the plant of a scenario.

    Args:
        scenario: What to build.
        derived: What was derived from it before.
    """
    derived = Derived.of(scenario) if derived is None else derived
    return PlantNode(
        derived.plant,
        derived.fail_safe,
        x0=scenario.plant.x0,
        period_ns=period_ns(scenario),
        playout_ns=_whole_periods(scenario.plant.playout_s, scenario),
        limits=limits_of(scenario, derived.robot),
    )


def filter_node(scenario: Scenario, driver: str, epoch: int, derived: Derived | None = None) -> FilterNode:
    """Return the filter of a scenario.

    Args:
        scenario: What to build.
        driver: ``live`` or ``lockstep``, for the log.
        epoch: Its session, as the driver stamps it on what it sends.
        derived: What was derived from the scenario before.
    """
    derived = Derived.of(scenario) if derived is None else derived
    tick_ns = period_ns(scenario)
    foresight, series = _foresight_of(scenario, derived)
    return FilterNode(
        derived.core,
        period_ns=tick_ns,
        foresight=foresight,
        series=series,
        schedule=EffectSchedule(
            period_ns=tick_ns, playout_ns=_whole_periods(scenario.plant.playout_s, scenario), epoch=epoch
        ),
        request=request_of(scenario, derived.robot.system.m),
        state_stale_ns=round(scenario.filter.stale_s * 1e9),
        starts_nearest=scenario.filter.start == "nearest",
        explainer=derived.explainer,
        wording=derived.wording,
        info=scenario_info(scenario, driver),
    )


def _foresight_of(scenario: Scenario, derived: Derived) -> tuple[Predictor | NoPrediction, Arming | Loose]:
    """Return what tells the state for which an input is made, and how inputs are sent."""
    tick_ns, hold_ns = period_ns(scenario), round(scenario.plant.hold_s * 1e9)
    tank = tank_of(scenario)
    if not scenario.filter.prediction:
        return NoPrediction(tank), Loose(period_ns=tick_ns, hold_ns=hold_ns)
    repeats = min(scenario.filter.repeats, MAX_VECTOR // derived.robot.system.m)
    return (
        Predictor(derived.plant, derived.fail_safe, tank, tick_ns),
        Arming(period_ns=tick_ns, hold_ns=hold_ns, repeats=repeats),
    )


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


def lockstep_loop(
    scenario: Scenario,
    observer: Observer | None = None,
    *,
    taps: Mapping[Topic, Tap] | None = None,
    derived: Derived | None = None,
) -> Lockstep:
    """Return the whole loop of a scenario in virtual time.

    Args:
        scenario: What to run.
        observer: Called with every message, see ``Lockstep``.
        taps: Called with what the nodes hand over, by topic, see ``Lockstep``.
        derived: What was derived from the scenario before; no other loop may be running on it.
    """
    epoch = 1
    derived = Derived.of(scenario) if derived is None else derived
    return Lockstep(
        [
            plant_node(scenario, derived),
            operator_node(scenario, epoch),
            filter_node(scenario, "lockstep", epoch, derived),
        ],
        period_ns=period_ns(scenario),
        links=link_settings(scenario),
        link_changes=link_changes(scenario),
        wall_offset_ns=VIRTUAL_WALL_NS,
        epoch=epoch,
        observer=observer,
        taps=taps,
    )
