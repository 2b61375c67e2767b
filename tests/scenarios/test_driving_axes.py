"""Axes that a page commands: how many, how strong, which of them together."""

import pytest
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.driving_axes import AUTHORITY, DrivingAxes
from passafe_services.scenarios.load import load_scenario, shipped_scenarios


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_axis_of_a_shipped_robot_is_commanded_once(name: str) -> None:
    scenario = load_scenario(name)
    axes = DrivingAxes.of(scenario)
    m = robot_of(scenario).commands
    assert len(axes.full) == m
    assert [axis for plane in axes.planes for axis in plane] == list(range(m))
    assert len(axes.names) == len(set(axes.names)) == len(axes.planes)


def test_limits_bound_the_authority() -> None:
    assert DrivingAxes.of(load_scenario("tight-limits")).full == (6.0, 6.0)
    assert DrivingAxes.of(load_scenario("walls-and-disks")).full == (AUTHORITY, AUTHORITY)
    lopsided = {"filter.input_low": [-1.0, -50.0], "filter.input_high": [9.0, 50.0]}
    assert DrivingAxes.of(load_scenario("walls-and-disks", lopsided)).full == (5.0, AUTHORITY)


def test_two_robots_have_a_plane_each() -> None:
    axes = DrivingAxes.of(load_scenario("two-robots"))
    assert (axes.planes, axes.names) == (((0, 1), (2, 3)), ("robot 1", "robot 2"))


def test_an_arm_is_commanded_by_its_tip() -> None:
    axes = DrivingAxes.of(load_scenario("arm-over-table"))
    assert (axes.full, axes.planes, axes.names) == ((AUTHORITY,) * 3, ((0, 1), (2,)), ("x and y", "z"))


def test_axes_of_a_task_frame_have_its_names() -> None:
    axes = DrivingAxes.of(load_scenario("arm-over-table"))

    assert axes.planes == ((0, 1), (2,))
    assert axes.names == ("x and y", "z")
