from math import pi, sqrt

import pytest
from msgspec.structs import replace
from own_robots import lift, scenario_of
from passafe_protocol.messages import EmergencyStop
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.export.ros2_messages import RosMessages
from small_log import WALL_NS, header, state, tick


def topics_of(converter: RosMessages, body: object) -> dict[str, object]:
    return {one.topic: one.message for one in converter.messages(header("plant", 0), body, WALL_NS)}


def test_two_points_have_poses_of_their_own() -> None:
    scenario = load_scenario("two-robots")

    found = topics_of(RosMessages(scenario), replace(state(1), x=scenario.plant.x0))

    assert {"/passafe/pose_1", "/passafe/pose_2", "/passafe/twist_1"} <= set(found)


def test_a_car_is_turned_by_its_heading() -> None:
    found = topics_of(RosMessages(load_scenario("unicycle-posts")), replace(state(1), x=(1.0, 2.0, pi / 2, 0.5, 0.0)))

    pose, speed = found["/passafe/pose"].pose, found["/passafe/twist"].twist.linear
    assert (pose.position.x, pose.position.y) == (1.0, 2.0)
    assert (pose.orientation.z, pose.orientation.w) == pytest.approx((sqrt(0.5), sqrt(0.5)))
    assert (speed.x, speed.y) == pytest.approx((0.0, 0.5))


def test_joints_have_states_and_no_poses() -> None:
    joint_chain = {"plant.model": "joint-chain", "plant.x0": [0.1, 0.2, 0.3, 0.4], "filter.barriers": []}

    found = topics_of(RosMessages(load_scenario("notomista-cai-2020", joint_chain)), state(1))

    assert set(found) == {"/joint_states", "/passafe/state", "/passafe/phase"}
    assert found["/joint_states"].position.tolist() == [1.0, 2.0]


def test_levels_are_positions_of_joints_without_effort() -> None:
    scenario = scenario_of(lift(), [0.1, 0.2, 0.3, 0.4], [0.0])

    joints = topics_of(RosMessages(scenario), replace(state(1), x=scenario.plant.x0, u=(1.0, 2.0)))["/joint_states"]

    assert (joints.position.tolist(), joints.velocity.tolist(), joints.effort.tolist()) == ([0.2], [0.4], [])


def test_without_a_scenario_there_are_numbers_alone() -> None:
    assert set(topics_of(RosMessages(None), state(1))) == {"/passafe/state", "/passafe/phase"}


def test_names_become_parts_of_topics() -> None:
    found = topics_of(RosMessages(None), tick(0, barriers=("left-wall", "2nd", "Ψ")))

    assert {"/passafe/barrier/left_wall", "/passafe/barrier/b_2nd", "/passafe/barrier/unnamed"} <= set(found)


def test_messages_without_a_counterpart_are_left_out() -> None:
    assert topics_of(RosMessages(None), EmergencyStop(1, "smoke")) == {}
