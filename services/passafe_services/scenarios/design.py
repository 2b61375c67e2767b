"""Builds the core's objects of a scenario: robot, storage, barriers, filter design, sampled plant."""

from dataclasses import replace
from typing import Final

import casadi as ca

from passafe.barrier_chain import Barrier
from passafe.design import FilterDesign, Law, Mode
from passafe.errors import DesignError
from passafe.limits import Limits
from passafe.models.joint_chain import MOST_JOINTS
from passafe.models.robot import Robot
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.storage import kinetic_energy, spring_energy, squared_norm
from passafe.tank import Tank
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.uncertain_robot import guard_uncertainty_of, uncertainty_of
from passafe_services.suggestion import suggestion

NEAREST: Final = 1.0 - 2.0**-40
"""k_i·dt of a guard: all but a millionth of a millionth of the way to the input that it is asked."""

FINER: Final = 0.4
"""Tolerance of a guard as a share of the filter's, which keeps rows by as much as its own tolerance at least."""


def robot_of(scenario: Scenario) -> Robot:
    """Return the scenario's robot, its fail-safe set to the gains of the barriers of its position and to its period.

    Raises:
        ScenarioError: A parameter that the model does not have, or an x0 of the wrong length.
        DesignError: A parameter outside its range.
    """
    model, x0 = scenario.plant.robot_model, scenario.plant.x0
    unknown = sorted(set(scenario.plant.parameters) - set(model.parameters))
    if unknown:
        allowed = ", ".join(model.parameters) + suggestion(unknown[0], model.parameters)
        raise ScenarioError(scenario.name, "plant.parameters", ", ".join(unknown), allowed)
    extra = _settings(scenario) if scenario.plant.robot is None else {}
    robot = model.build(**scenario.plant.parameters, **extra)
    if len(x0) != robot.system.n:
        raise ScenarioError(
            scenario.name, "plant.x0", f"{len(x0)} numbers", f"{robot.system.n}, the states of the model"
        )
    return robot


def _settings(scenario: Scenario) -> dict[str, float]:
    """Return what a model of the core takes from the scenario besides its parameters."""
    name = scenario.plant.model
    settings: dict[str, float] = {"gamma_1": _largest_gain(scenario, 0), "dt_s": scenario.dt_s}
    if name == "lagged-point":
        settings["gamma_2"] = _largest_gain(scenario, 1)
    if name == "joint-chain":
        settings["joints"] = _joints(scenario)
    return settings


def _largest_gain(scenario: Scenario, level: int) -> float:
    """Return the largest gain of one class-K function among the barriers of the position."""
    gains = [
        barrier.class_k[level].gain
        for barrier in scenario.barriers
        if barrier.is_of_position and level < len(barrier.class_k)
    ]
    return max(gains, default=0.0)


def _joints(scenario: Scenario) -> int:
    joints, odd = divmod(len(scenario.plant.x0), 2)
    if odd or not 1 <= joints <= MOST_JOINTS:
        allowed = f"an angle and a speed for each of 1 to {MOST_JOINTS} joints"
        raise ScenarioError(scenario.name, "plant.x0", f"{len(scenario.plant.x0)} numbers", allowed)
    return joints


def storage_of(scenario: Scenario, robot: Robot) -> ca.SX:
    """Return the scenario's storage function V(x), J.

    Raises:
        ScenarioError: The robot's own, and it brings none; or one of the velocity, and it has none.
    """
    passivity = scenario.filter.passivity
    if passivity.storage == "own":
        if robot.storage is None:
            raise ScenarioError(scenario.name, "filter.passivity.storage", "own", "a robot that brings its storage")
        return robot.storage
    if passivity.storage in {"kinetic", "spring"} and not robot.velocity.numel():
        allowed = "squared-norm, or own: the robot has no velocity"
        raise ScenarioError(scenario.name, "filter.passivity.storage", passivity.storage, allowed)
    if passivity.storage == "kinetic":
        return kinetic_energy(robot.velocity)
    if passivity.storage == "spring":
        return spring_energy(robot.position, robot.velocity, stiffness=passivity.spring_stiffness_per_s2)
    return squared_norm(robot.system.x)


def feedback_of(scenario: Scenario, robot: Robot) -> ca.SX:
    """Return the scenario's feedback u_fb(x), shape (m, 1).

    Raises:
        ScenarioError: The robot's own, and it brings none; or gains, and it has not one input for each coordinate.
    """
    config = scenario.filter.feedback
    if config.kind == "own":
        if robot.feedback is None:
            raise ScenarioError(scenario.name, "filter.feedback.kind", "own", "a robot that brings a feedback")
        return robot.feedback
    if not config.k_p and not config.k_d:
        return ca.SX.zeros(robot.system.m)
    if robot.position.numel() != robot.system.m:
        got = f"k_p, k_d for {robot.position.numel()} coordinates and {robot.system.m} inputs"
        raise ScenarioError(scenario.name, "filter.feedback", got, 'as many of both, or kind = "own"')
    if config.k_d and not robot.velocity.numel():
        raise ScenarioError(scenario.name, "filter.feedback.k_d", f"{config.k_d:g}", "0: the robot has no velocity")
    return robot.proportional_derivative(k_p=config.k_p, k_d=config.k_d)


def barriers_of(scenario: Scenario, robot: Robot) -> tuple[Barrier, ...]:
    """Return the scenario's barriers in the order of the file."""
    return tuple(
        Barrier(
            name=config.name,
            h=config.h(robot),
            class_k=tuple(gamma.function() for gamma in config.class_k),
            derivative_bounds=config.derivative_bounds(robot),
        )
        for config in scenario.barriers
    )


def tank_of(scenario: Scenario) -> Tank:
    """Return the scenario's energy tank; it is tracked and reported even if the passivity row does not use it."""
    passivity = scenario.filter.passivity
    return Tank(
        initial_j=passivity.tank_initial_j,
        reserve_j=passivity.tank_reserve_j,
        max_j=passivity.tank_max_j,
        rate_per_s=passivity.tank_rate_per_s,
    )


def design_of(scenario: Scenario, robot: Robot) -> FilterDesign:
    """Return the design of the scenario's filter.

    Raises:
        ScenarioError: As for ``limits_of``.
        DesignError: Parts of the design do not fit together, for example a barrier without relative degree.
    """
    limits_of(scenario, robot)  # what it refuses is named as the file has it
    config = scenario.filter
    passivity = config.passivity
    return FilterDesign(
        system=robot.system,
        u_fb=feedback_of(scenario, robot),
        fail_safe=robot.fail_safe,
        barriers=barriers_of(scenario, robot),
        passivity=Passivity(
            V=storage_of(scenario, robot),
            class_k=passivity.class_k.function(),
            slack_weight=passivity.slack_weight,
            tank=tank_of(scenario) if passivity.kind == "tank" else None,
            derivative_bounds=robot.power_bounds if passivity.storage == "own" else None,
        ),
        k_i=config.k_i,
        dt_s=scenario.dt_s,
        input_bound=config.input_bound,
        input_norm_bound=config.input_norm_bound,
        input_rate_bound_per_s=config.input_rate_bound_per_s,
        input_low=config.input_low,
        input_high=config.input_high,
        input_norms=config.norms(),
        input_half_spaces=config.half_spaces(),
        input_rate_low_per_s=config.input_rate_low_per_s,
        input_rate_high_per_s=config.input_rate_high_per_s,
        between_samples=config.between_samples,
        gatekeeper=config.gatekeeper,
        hold_s=scenario.plant.hold_s,
        law=Law(config.law),
        mode=Mode(config.mode),
        uncertainty=uncertainty_of(scenario, robot) if has_robust_rows(scenario) else None,
    )


def guard_design_of(scenario: Scenario, robot: Robot) -> FilterDesign:
    """Return the design of the guard at the plant: the safety rows alone, nearest to the input that it is asked.

    The rows are those of the filter, hold included, and its tolerance is finer, so that what the filter certified
    passes. k_i is as large as a sampled law can have it, so that only limits of the rate keep the guard from what it is
    asked.

    Raises:
        ScenarioError: As for ``limits_of``.
        DesignError: As for ``design_of``.
    """
    design = design_of(scenario, robot)
    return replace(
        design,
        tolerance=replace(design.tolerance, residual=FINER * design.tolerance.residual),
        u_fb=ca.SX.zeros(robot.system.m),
        k_i=NEAREST / scenario.dt_s,
        law=Law.SAMPLED,
        mode=Mode.SAFE,
        gatekeeper=False,
        uncertainty=guard_uncertainty_of(scenario, robot),
    )


def has_robust_rows(scenario: Scenario) -> bool:
    """Return whether the rows of the scenario's filter hold for its sets."""
    return scenario.uncertainty is not None and scenario.uncertainty.in_filter


def limits_of(scenario: Scenario, robot: Robot) -> Limits:
    """Return the scenario's input limits.

    Raises:
        ScenarioError: Lists of another number of axes than the robot has, or limits that leave no input.
    """
    try:
        return scenario.filter.limits(robot.system.m)
    except DesignError as error:
        raise ScenarioError(scenario.name, f"filter.{error.field}", str(error.got), error.allowed) from error


def sampled_plant_of(scenario: Scenario, robot: Robot) -> SampledPlant:
    """Return the scenario's plant, stepped at its rate."""
    return SampledPlant(robot.system, storage_of(scenario, robot), scenario.dt_s)
