"""The check of the fail-safe of robots whose states are not positions, then velocities."""

from dataclasses import replace

import casadi as ca
import pytest
from own_robots import car_with_a_hitch, lift, on_three_cables, scenario_of, two_tanks
from passafe_services.tools.check.scenario_check import load_findings

from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.robot import Robot

SCOPE = FailSafeScope(kept_gains=(5.0, 5.0), dt_s=0.005)


def limits_of(robot: Robot, x0: list[float], degree: int = 2, **keys: object) -> str:
    """Return what is found of the limits of the input, of a robot that states what its fail-safe keeps."""
    stated = replace(robot, fail_safe_scope=SCOPE, fail_safe_condition="it stops")
    scenario = scenario_of(stated, x0, [0.0] * robot.system.m, degree=degree, **keys)
    [found] = [one.found for one in load_findings(scenario) if one.subject == "limits of the input"]
    return found


def test_law_of_a_robot_without_a_velocity_is_that_at_the_start() -> None:
    found = limits_of(two_tanks(), [1.0, 1.0], degree=1, input_low=0.0, input_high=2.0)

    assert found == "at 0 on every axis it asks for 0.05 to 0.05 of input 1, which has 0 to 2"


def test_speed_is_taken_from_the_states_that_make_it() -> None:
    assert "at 3 on every axis it asks for 15 of 20" in limits_of(lift(), [0.0, 0.0, 0.0, 3.0], input_bound=20.0)
    hitched = limits_of(car_with_a_hitch(), [0.0, 0.0, 0.0, 0.0, 2.0], barriers=[], input_bound=1.0)
    assert "at 2 on every axis it asks for" in hitched


@pytest.mark.parametrize(("low", "found"), [(-2.0, "has -2 to 4"), (0.0, "has 0 to 4")])
def test_limits_of_each_side_count(low: float, found: str) -> None:
    robot = replace(on_three_cables(), fail_safe=ca.SX.zeros(3))
    assert found in limits_of(robot, [0.0] * 4, input_low=low, input_high=4.0)
