"""The arm's scenario: its kinds of barriers, and a second in which it has to keep clear."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from passafe_protocol.messages import FilterStatus, FilterTick, Header, Message, PlantState
from passafe_protocol.topics import Topic
from passafe_services.scenarios.barrier_kinds.body_spheres import sphere_of
from passafe_services.scenarios.design import barriers_of, design_of, robot_of
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop

from passafe.errors import DesignError

RUN_S = 1.2


def test_the_arm_has_some_sixty_rows_with_names_of_their_own() -> None:
    scenario = load_scenario("arm-over-table")
    names = [barrier.name for barrier in scenario.barriers]

    assert len(names) == 2 * 10 + 7 + 7 + 14 + 14
    assert {"ball: tip", "table: wrist", "itself: upper arm 1, tip", "joint 4 high", "speed 7 low"} <= set(names)
    assert {barrier.h_unit for barrier in scenario.barriers} == {"m²", "m", "rad", "rad/s"}
    robot = robot_of(scenario)
    assert design_of(scenario, robot).passivity.derivative_bounds is robot.power_bounds
    with_bounds = [barrier for barrier in barriers_of(scenario, robot) if barrier.derivative_bounds is not None]
    assert len(with_bounds) == 34


def test_pushed_at_a_ball_it_stops_there() -> None:
    scenario = load_scenario("arm-over-table", {"duration_s": RUN_S})
    states, statuses = [], set()

    def observe(_topic: Topic, _header: Header, body: Message) -> None:
        if isinstance(body, PlantState):
            states.append(body.x)
        elif isinstance(body, FilterTick):
            statuses.add(body.status)

    lockstep_loop(scenario, observe).run(round(RUN_S * scenario.rate_hz))
    robot = robot_of(scenario)
    h = ca.Function("h", [robot.system.x], [ca.vertcat(*(barrier.h for barrier in barriers_of(scenario, robot)))])
    lowest = min(float(np.array(h(x)).min()) for x in states[::5])

    assert 0.0 <= lowest < 5e-3
    assert statuses <= {FilterStatus.PASSED, FilterStatus.MODIFIED}
    assert FilterStatus.MODIFIED in statuses


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"filter.barriers.table.spheres": ["wrst"]}, "sphere 'wrst' of barrier 'table', allowed upper arm 1"),
        ({"filter.barriers.itself.pairs": [["tip", "tip"]]}, "allowed two spheres in each"),
        ({"filter.barriers.itself.pairs": [["tip", "nose"]]}, "sphere 'nose' of barrier 'itself'"),
        ({"filter.barriers.ball.centre": [0.0, 0.0]}, "filter.barriers"),
    ],
)
def test_what_fits_no_sphere_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        load_scenario("arm-over-table", changes)


def test_a_robot_without_spheres_has_no_such_barrier() -> None:
    ball = {"kind": "ball-keep-out", "name": "ball", "centre": [0.0, 0.0, 0.0], "radius": 1.0, "class_k": []}
    ball["class_k"] = [{"kind": "linear", "gain": 1.0}] * 3
    with pytest.raises(ScenarioError, match="allowed with a robot that has spheres, which 'damped-point' has not"):
        load_scenario("notomista-cai-2020", {"filter.barriers": [ball]})
    robot = robot_of(load_scenario("notomista-cai-2020"))
    with pytest.raises(DesignError, match="none: the robot has no spheres"):
        sphere_of(robot, "tip")
