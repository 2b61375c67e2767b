"""Loops of robots that a user's function returns, of kinds that no shipped robot is."""

from collections import Counter
from collections.abc import Mapping

import casadi as ca
import pytest
from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.robots.carried_robot import CarriedRobot
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of

from passafe.errors import NotAllowedError
from passafe.models.robot import Robot
from passafe.system import System

VELOCITIES = {
    "kind": "coordinate-limits",
    "name": "limits",
    "of": "velocity",
    "low": [-1.0, -1.0],
    "high": [1.0, 1.0],
    "class_k": [{"kind": "linear", "gain": 4.0}] * 3,
}


def scenario_of(
    robot: Robot, x0: list[float], command: list[float], *, degree: int = 2, **filter_keys: object
) -> Scenario:
    """Return a scenario of a second in which a robot is driven by one command, with its own barriers."""
    own = [
        {"kind": "own", "name": name, "class_k": [{"kind": "linear", "gain": 4.0}] * (degree + 1)}
        for name in robot.barriers
    ]
    carried = CarriedRobot.of(robot, made_by="own", built_with={})
    keys: Mapping[str, object] = {"mode": "safe", "k_i": 40.0, "barriers": own, **filter_keys}
    return scenario_from(
        {
            "schema_version": 1,
            "name": "own",
            "title": "A robot of a user's own",
            "duration_s": 1.0,
            "rate_hz": 200.0,
            "plant": {"model": "own", "robot": carried.model_dump(mode="json"), "x0": x0},
            "operator": {"source": {"kind": "constant", "value": command}},
            "filter": keys,
        },
        "own.toml",
    )


def driven(scenario: Scenario) -> tuple[list[PlantState], Counter[str]]:
    """Return the states and the statuses of a scenario's loop."""
    states: list[PlantState] = []
    statuses: Counter[str] = Counter()

    def take(_topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantState):
            states.append(body)
        elif isinstance(body, FilterTick):
            statuses[body.status.name] += 1

    loop = lockstep_loop(scenario, take)
    loop.run(steps_of(scenario))
    loop.finish()
    return states, statuses


def on_three_cables() -> Robot:
    """Return a mass that three inputs pull along two axes, with two outputs: a port that is not y and u."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 3)
    pull = ca.DM([[1, -0.5, -0.5], [0, 0.8, -0.8]]) @ u
    system = System(x=x, u=u, f=ca.vertcat(x[2:], pull), y=x[2:], port_y=x[2:], port_u=pull)
    return Robot(
        system=system,
        position=x[:2],
        points=1,
        fail_safe=-ca.vertcat(2 * x[2], 0, 0),
        barriers={"wall": 0.2 - x[0]},
    )


def test_robot_with_fewer_outputs_than_inputs_drives() -> None:
    states, statuses = driven(scenario_of(on_three_cables(), [0.0] * 4, [2.0, 0.5, 0.5], input_low=0.0))

    assert (len(states[-1].y), len(states[-1].u)) == (2, 3)
    assert 0.1 < states[-1].x[0] < 0.2
    assert set(statuses) == {"PASSED", "MODIFIED"}


def two_tanks() -> Robot:
    """Return levels of two tanks that pumps fill: no mechanics, and the input is the rate of the position."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    runs = 0.05 * ca.sqrt(x)
    system = System(x=x, u=u, f=u - runs, y=x)
    barriers = {"full": 1.5 - x[0], "dry": x[1] - 0.5}
    return Robot(system=system, position=x, fail_safe=runs, storage=ca.sumsqr(x) / 2, barriers=barriers)


def test_robot_without_a_velocity_drives() -> None:
    states, statuses = driven(scenario_of(two_tanks(), [1.0, 1.0], [2.0, 0.0], degree=1, input_low=0.0, input_high=2.0))

    assert 1.45 < states[-1].x[0] < 1.5
    assert set(statuses) == {"PASSED", "MODIFIED"}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"passivity": {"storage": "kinetic"}}, "storage: got kinetic, allowed squared-norm, or own"),
        ({"feedback": {"k_d": 1.0}}, "feedback.k_d: got 1, allowed 0: the robot has no velocity"),
        ({"barriers": [VELOCITIES]}, "velocity coordinate 1, allowed a robot with a velocity"),
    ],
)
def test_what_takes_a_velocity_is_refused_without_one(keys: dict[str, object], words: str) -> None:
    with pytest.raises(NotAllowedError, match=words):
        driven(scenario_of(two_tanks(), [1.0, 1.0], [2.0, 0.0], degree=1, **keys))
