"""Every barrier in plain numbers against the core's, from the same scenario."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from closed_form import paper_scenario
from passafe_dashboard.obstacles import Disk, HalfPlane, Limit, Separation, obstacles_of, unit_of_h
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.schema import Scenario

LINEAR = {"kind": "linear", "gain": 2.0}
SWING = {"kind": "swing", "amplitude_m": (1.0, -0.5), "frequency_hz": 0.3, "phase_rad": 0.4}
TRAVEL = {"kind": "travel", "velocity_m_per_s": (0.5, -0.25)}
CIRCLE = {"kind": "circle", "radius_m": 1.5, "frequency_hz": 0.2, "phase_rad": -0.7}
DISK = {"kind": "disk-keep-out", "centre": (0.3, -0.2), "radius": 0.8}
ELLIPSE = {"kind": "ellipse-keep-out", "centre": (0.3, -0.2), "semi_axes_m": (0.4, 1.1), "rotation_rad": 0.9}
WALL = {"kind": "half-plane", "normal": (0.6, -2.0), "offset": 0.7}
PLACES: list[dict[str, Any]] = [
    shape | ({} if motion is None else {"motion": motion})
    for shape in (DISK, DISK | {"kind": "disk-keep-in"}, ELLIPSE, ELLIPSE | {"kind": "ellipse-keep-in"}, WALL)
    for motion in (None, SWING, TRAVEL, CIRCLE)
]
ROOM = {"kind": "room", "low_m": (-1.0, -2.0), "high_m": (3.0, 4.0)}
SPEED = {"kind": "speed-limit", "limit_m_per_s": 1.5}
APART = {"kind": "keep-apart", "distance_m": 0.5}


def limits(of: str, count: int) -> dict[str, Any]:
    return {
        "kind": "coordinate-limits",
        "of": of,
        "low": [-1.0 - i for i in range(count)],
        "high": [1.5 + i for i in range(count)],
    }


def scenario(model: str, states: int, barriers: list[dict[str, Any]], degree: int = 2) -> Scenario:
    values = paper_scenario().model_dump()
    values["plant"] |= {"model": model, "parameters": {}, "x0": [0.0] * states}
    values["filter"]["barriers"] = [
        barrier
        | {"name": f"b{i}"}
        | {"class_k": [LINEAR] * (degree + (barrier["kind"] != "speed-limit" and barrier.get("of") != "velocity"))}
        for i, barrier in enumerate(barriers)
    ]
    return Scenario.model_validate(values)


ALL = {
    "damped-point": scenario("damped-point", 4, [*PLACES, ROOM, SPEED, limits("position", 2), limits("velocity", 2)]),
    "lagged-point": scenario("lagged-point", 6, [*PLACES, ROOM, SPEED], 3),
    "two-points": scenario(
        "two-points", 8, [*PLACES, ROOM, SPEED, APART, DISK | {"point": 2}, SPEED | {"point": 1}, limits("velocity", 4)]
    ),
    "joint-chain": scenario("joint-chain", 14, [limits("position", 7), limits("velocity", 7)]),
}


@pytest.mark.parametrize("model", ALL)
def test_h_in_plain_numbers_is_the_core_s(model: str) -> None:
    robot = robot_of(ALL[model])
    barriers, obstacles = barriers_of(ALL[model], robot), obstacles_of(ALL[model])
    core = ca.Function("h", [robot.system.x, robot.system.t], [ca.vertcat(*(barrier.h for barrier in barriers))])
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, t_s = rng.uniform(-3, 3, robot.system.n).tolist(), rng.uniform(0, 10)
        assert [obstacle.h(x, t_s) for obstacle in obstacles] == pytest.approx(
            core(x, t_s).full().ravel().tolist(), rel=1e-12, abs=1e-12
        )
    assert [obstacle.name for obstacle in obstacles] == [barrier.name for barrier in barriers]


def test_shapes_keep_the_scenario_s_order_and_say_their_unit() -> None:
    shapes = obstacles_of(scenario("damped-point", 4, [WALL, DISK, ELLIPSE, SPEED]))
    assert shapes[:2] == (
        HalfPlane(name="b0", normal=(0.6, -2.0), offset=0.7),
        Disk(name="b1", centre=(0.3, -0.2), radius=0.8),
    )
    assert [unit_of_h(shape) for shape in shapes] == ["m", "m²", "m²", "m²/s²"]


def test_limits_have_the_unit_of_their_coordinate() -> None:
    joints = obstacles_of(scenario("joint-chain", 2, [limits("position", 1), limits("velocity", 1)]))
    points = obstacles_of(scenario("two-points", 8, [limits("position", 4), limits("velocity", 4), APART]))
    assert [unit_of_h(one) for one in joints] == ["rad", "rad", "rad/s", "rad/s"]
    assert [unit_of_h(one) for one in points] == ["m"] * 8 + ["m/s"] * 8 + ["m²"]
    assert joints[3] == Limit(name="b1 1 high", place=1, bound=1.5, upper=True, unit="rad/s")
    assert points[-1] == Separation(name="b2", distance=0.5)
