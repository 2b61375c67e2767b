"""A robot as data: it returns with the same bits, and is refused where it was changed."""

import json
import zlib
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from typing import Any

import casadi as ca
import numpy as np
import pytest
from passafe_services.scenarios.robots import carried_robot
from passafe_services.scenarios.robots.carried_robot import MOST_BYTES, CarriedRobot, built_robot
from pydantic import ValidationError

from passafe.errors import DesignError
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.robot import Robot
from passafe.models.seven_joint_arm import seven_joint_arm
from passafe.models.unicycle import unicycle

MADE = unicycle(drag=0.7)
CARRIED = CarriedRobot.of(MADE, made_by="unicycle", built_with={"drag": 0.7})


def functions(robot: Robot) -> ca.Function:
    system, task = robot.system, robot.task
    assert task is not None
    assert robot.drawing is not None
    laws = [robot.position, robot.velocity, robot.fail_safe, robot.feedback, robot.storage, *robot.stopping_hull]
    drawn = [robot.drawing.points, robot.drawing.heading]
    every = ca.vertcat(system.f, system.y, system.power, task.u_h, *laws, *drawn, *robot.barriers.values())
    return ca.Function("every", [system.x, system.u, task.command], [every])


def test_robot_returns_with_the_same_bits() -> None:
    before, after, rng = functions(MADE), functions(CARRIED.robot()), np.random.default_rng(1)
    for _ in range(100):
        x, u, w = rng.normal(size=5), rng.normal(size=2), rng.normal(size=2)
        assert after(x, u, w).full().tobytes() == before(x, u, w).full().tobytes()


def test_what_is_no_function_returns_too() -> None:
    after = CARRIED.robot()

    assert after.task is not None
    assert MADE.task is not None
    assert after.drawing is not None
    assert MADE.drawing is not None
    assert (after.points, after.input_unit, after.task.axes) == (MADE.points, MADE.input_unit, MADE.task.axes)
    assert after.drawing.outline == MADE.drawing.outline
    assert after.fail_safe_scope == MADE.fail_safe_scope
    assert after.fail_safe_condition == MADE.fail_safe_condition


def test_limits_of_the_fail_safe_return_too() -> None:
    scope = FailSafeScope(kept_gains=(2.0,), dt_s=0.01, top_speed=1.5)
    carried = CarriedRobot.of(replace(MADE, fail_safe_scope=scope, fail_safe_gain=3.0), made_by="x", built_with={})

    assert (carried.robot().fail_safe_scope, carried.robot().fail_safe_gain) == (scope, 3.0)


def test_robot_of_an_earlier_log_keeps_its_digest() -> None:
    parts = CARRIED.model_dump(mode="json")
    earlier = {name: value for name, value in parts.items() if name not in {"fail_safe_top_speed", "fail_safe_gain"}}
    earlier["digest"] = sha256(
        json.dumps({name: value for name, value in earlier.items() if name != "digest"}, sort_keys=True).encode()
    ).hexdigest()

    assert CarriedRobot.model_validate(earlier) == CARRIED


def test_robot_of_a_robot_is_the_same_data() -> None:
    assert CarriedRobot.of(CARRIED.robot(), made_by="unicycle", built_with={"drag": 0.7}) == CARRIED


def test_json_of_a_robot_is_the_robot() -> None:
    assert CarriedRobot.model_validate_json(CARRIED.model_dump_json()) == CARRIED


def test_parameter_of_the_dynamics_can_be_changed() -> None:
    faster, slower = built_robot(CARRIED, drag=0.7), built_robot(CARRIED, drag=1.4)
    at = [0, 0, 0, 1.0, 0], [0, 0], [0, 0]

    assert float(functions(faster)(*at)[3]) == -0.7
    assert float(functions(slower)(*at)[3]) == -1.4


def test_parameter_that_the_functions_contain_cannot() -> None:
    carried = CarriedRobot.of(MADE, made_by="car.py:car", built_with={"nose_m": 0.3})
    with pytest.raises(DesignError, match=r"nose_m: got 0.4, allowed 0.3, with which car.py:car made .* change drag"):
        built_robot(carried, nose_m=0.4)


@pytest.mark.parametrize(
    "change",
    [
        {"points": 0},
        {"fail_safe_condition": "keeps everything"},
        {"kept_gains": (100.0,)},
        {"built_with": {"drag": 0.8}},
        {"functions": CARRIED.functions[:-8] + "AAAAAAA="},
        {"digest": "0" * 64},
    ],
)
def test_robot_that_was_changed_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=r"digest: got .* it was changed or damaged"):
        CarriedRobot.model_validate(CARRIED.model_dump() | change)


def forged(functions: str, **parts: Any) -> CarriedRobot:  # noqa: ANN401 - parts of every kind
    """Return a robot with other functions and the digest that fits them, as a stranger can make it."""
    changed = CARRIED.model_copy(update={"functions": functions} | parts)
    return CarriedRobot.model_validate(changed.model_dump() | {"digest": carried_robot._digest(changed)})


@pytest.mark.parametrize(
    "functions",
    [
        "",
        "not base64",
        b64encode(b"no zlib").decode(),
        b64encode(zlib.compress(b"\xff")).decode(),
        b64encode(zlib.compress(bytes(MOST_BYTES + 1))).decode(),
        b64encode(zlib.compress(b"{}")).decode(),
        b64encode(zlib.compress(json.dumps({"instructions": [], "outputs": {}}).encode())).decode(),
    ],
)
def test_functions_that_are_none_are_refused(functions: str) -> None:
    with pytest.raises(DesignError, match="robot: got"):
        forged(functions).robot()


def test_other_numbers_of_states_are_refused() -> None:
    with pytest.raises(DesignError, match="robot: got"):
        forged(CARRIED.functions, states=4).robot()


def test_drawing_without_its_points_is_refused() -> None:
    bare = CarriedRobot.of(unicycle_without_drawing(), made_by="x", built_with={})
    with pytest.raises(DesignError, match="no drawing points"):
        forged(bare.functions).robot()


def unicycle_without_drawing() -> Robot:
    return Robot(
        system=MADE.system, position=MADE.position, points=1, fail_safe=MADE.fail_safe, task=MADE.task, velocity=[0, 0]
    )


def test_arm_returns_with_its_spheres_and_bounds() -> None:
    made = seven_joint_arm()
    carried = CarriedRobot.of(made, made_by="seven_joint_arm", built_with={})
    after = carried.robot()
    assert len(carried.functions) < 200_000

    def measures(robot: Robot) -> bytes:
        system, power = robot.system, robot.power_bounds
        assert power is not None
        bounds = [power, *(sphere.bounds for sphere in robot.spheres)]
        sizes = [power.x_size, power.u_size, power.held_s]
        orders = [ca.substitute([one.orders], [one.x_size, one.u_size, one.held_s], sizes)[0] for one in bounds]
        every = ca.vertcat(system.f, system.power, *orders, *(sphere.centre for sphere in robot.spheres))
        function = ca.Function("every", [system.x, system.u, *sizes], [every])
        return bytes(function(0.3, 0.2, 0.4, 0.5, 0.01).full().tobytes())

    assert measures(after) == measures(made)
    assert [sphere.radius_m for sphere in after.spheres] == [sphere.radius_m for sphere in made.spheres]


def test_sphere_without_its_place_is_refused() -> None:
    sphere = carried_robot.CarriedSphere(name="hand", radius_m=0.1)
    with pytest.raises(DesignError, match="no place of a sphere"):
        forged(CARRIED.functions, spheres=(sphere,)).robot()


def test_robot_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(carried_robot, "MOST_PACKED", 100)
    with pytest.raises(DesignError, match=r"functions of .* bytes, allowed at most 100"):
        CarriedRobot.of(MADE, made_by="unicycle", built_with={})
