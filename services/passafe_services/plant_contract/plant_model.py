"""Model of the plant, shared by plant and filter: dynamics, fail-safe, limits, and times in whole periods."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

from passafe.filter import SafetyPassivityFilter
from passafe.limits import Limits
from passafe.models.robot import Robot
from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth
from passafe_services.plant_contract.fail_safe import FailSafe
from passafe_services.scenarios.design import guard_design_of, limits_of, robot_of, sampled_plant_of
from passafe_services.scenarios.schema import Scenario


def period_ns(scenario: Scenario) -> int:
    """Return the period of one tick, ns."""
    return round(1e9 / scenario.rate_hz)


@dataclass(frozen=True, kw_only=True)
class PlantModel:
    """Plant of a scenario, as simulated by its process and predicted by the filter.

    Attributes:
        robot: The robot.
        dynamics: Its model, stepped at the scenario's rate.
        fail_safe: Rule for missing inputs.
        limits: Input limits.
        period_ns: Period of a step, ns.
        playout_ns: Play-out time, whole periods, ns.
        hold_ns: Longest time for which an input may be in force, ns.
        scenario: The scenario.
    """

    robot: Robot
    dynamics: SampledPlant
    fail_safe: FailSafe
    limits: Limits
    period_ns: int
    playout_ns: int
    hold_ns: int
    scenario: Scenario

    @cached_property
    def guard_core(self) -> SafetyPassivityFilter:
        """Rows of the guard at the plant, compiled when they are asked for: the filter has no use for them."""
        return SafetyPassivityFilter(guard_design_of(self.scenario, self.robot))

    @cached_property
    def guard_growth(self) -> ErrorGrowth | None:
        """Growth of errors by the guard's sets; ``None`` without."""
        design = self.guard_core.design
        return None if design.uncertainty is None else ErrorGrowth(design)

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Compile the model of a scenario.

        Raises:
            ScenarioError: The parameters or x0 do not fit the model.
        """
        robot = robot_of(scenario)
        limits = limits_of(scenario, robot)
        tick_ns, hold_ns = period_ns(scenario), round(scenario.plant.hold_s * 1e9)
        return cls(
            robot=robot,
            dynamics=sampled_plant_of(scenario, robot),
            fail_safe=FailSafe(robot, limits, period_ns=tick_ns, hold_ns=hold_ns),
            limits=limits,
            period_ns=tick_ns,
            playout_ns=round(scenario.plant.playout_s * scenario.rate_hz) * tick_ns,
            hold_ns=hold_ns,
            scenario=scenario,
        )
