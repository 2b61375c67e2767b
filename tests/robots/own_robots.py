"""Robots that a user's function may return, of kinds that no shipped robot is, and scenarios that drive them."""

from collections.abc import Mapping

import casadi as ca
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.robots.carried_robot import CarriedRobot
from passafe_services.scenarios.schema import Scenario

from passafe.models.robot import Robot
from passafe.system import System


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


def two_tanks() -> Robot:
    """Return levels of two tanks that pumps fill: no mechanics, and the input is the rate of the position."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 2)
    runs = 0.05 * ca.sqrt(x)
    system = System(x=x, u=u, f=u - runs, y=x)
    barriers = {"full": 1.5 - x[0], "dry": x[1] - 0.5}
    return Robot(system=system, position=x, fail_safe=runs, storage=ca.sumsqr(x) / 2, barriers=barriers)


def car_with_a_hitch() -> Robot:
    """Return a car with the states place, heading, speed and angle of a hitch, placed by its nose 0.3 m ahead."""
    x, u = ca.SX.sym("x", 5), ca.SX.sym("u", 2)
    ahead = ca.vertcat(ca.cos(x[2]), ca.sin(x[2]))
    nose = x[:2] + 0.3 * ahead
    system = System(x=x, u=u, f=ca.vertcat(x[4] * ahead, u[1], -u[1], u[0]), y=ca.vertcat(x[4], x[2]))
    return Robot(
        system=system,
        position=nose,
        velocity=x[4] * ahead,
        points=1,
        fail_safe=-x[4] * ca.SX([1, 0]),
        barriers={"post": ca.sumsqr(nose - ca.DM([0, 2])) - 0.25, "hitch": 0.9 - x[3], "speed": 1 - x[4] ** 2},
    )


def lift() -> Robot:
    """Return a load on a spring: its position is the second state of four."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 1)
    pull = 60 * (x[0] - x[1])
    system = System(x=x, u=u, f=ca.vertcat(x[2:], u - pull - 6 * x[2], pull - 3 * x[3]), y=x[2])
    return Robot(system=system, position=x[1], fail_safe=-5 * x[3])
