"""h, unit and motion of every kind of barrier, against numbers computed from the words of the file."""

from math import cos, pi, sin
from typing import Any

import casadi as ca
import numpy as np
import pytest
from passafe_dashboard.barrier_values import BarrierValues
from passafe_dashboard.columns import moving_table
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.barrier_kinds.ellipse import EllipseBarrier
from passafe_services.scenarios.barrier_kinds.half_plane import HalfPlaneBarrier
from passafe_services.scenarios.barrier_kinds.registry import BARRIER_KINDS, kind_words
from passafe_services.scenarios.barrier_kinds.speed_limit import SpeedBarrier
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.load import load_scenario
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
    values = load_scenario("notomista-cai-2020").model_dump()
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


def displacement(motion: dict[str, Any] | None, t_s: float) -> Any:  # noqa: ANN401 - an array
    """Displacement of a motion as its words state it, m."""
    if motion is None:
        return np.zeros(2)
    if motion["kind"] == "travel":
        return np.array(motion["velocity_m_per_s"]) * t_s
    angle = 2 * pi * motion["frequency_hz"] * t_s + motion["phase_rad"]
    if motion["kind"] == "swing":
        return np.array(motion["amplitude_m"]) * sin(angle)
    return motion["radius_m"] * np.array([cos(angle), sin(angle)])


def h_of_place(shape: dict[str, Any], p: Any) -> float:  # noqa: ANN401 - an array
    """H of a shape of ``PLACES`` that has not moved, in numbers."""
    if shape["kind"] == "half-plane":
        return float(np.dot(shape["normal"], p) - shape["offset"])
    sign = -1.0 if shape["kind"].endswith("in") else 1.0
    along = p - np.array(shape["centre"])
    if shape["kind"].startswith("disk"):
        return float(sign * (along @ along - shape["radius"] ** 2))
    c, s = cos(shape["rotation_rad"]), sin(shape["rotation_rad"])
    a = min(shape["semi_axes_m"])
    scaled = np.array([c * along[0] + s * along[1], -s * along[0] + c * along[1]]) / np.array(shape["semi_axes_m"])
    return float(sign * a**2 * (scaled @ scaled - 1))


def expected_h(config: dict[str, Any], model: str, x: Any, t_s: float) -> list[float]:  # noqa: ANN401 - an array
    """Values of the barriers that one entry of a scenario file stands for, from the words of the file alone."""
    k = {"joint-chain": 7, "two-points": 4}.get(model, 2)
    position, velocity = x[:k], x[k : 2 * k]
    kind = config["kind"]
    if kind == "keep-apart":
        return [float(np.sum((position[:2] - position[2:]) ** 2) - config["distance_m"] ** 2)]
    if kind == "coordinate-limits":
        q = velocity if config["of"] == "velocity" else position
        pairs = zip(q, config["low"], config["high"], strict=True)
        return [float(value) for each, low, high in pairs for value in (each - low, high - each)]
    values: list[float] = []
    for point in (1, 2) if model == "two-points" and config.get("point") is None else (config.get("point") or 1,):
        p, v = (part[2 * point - 2 : 2 * point] for part in (position, velocity))
        if kind == "speed-limit":
            values.append(float(config["limit_m_per_s"] ** 2 - v @ v))
        elif kind == "room":
            (low_1, low_2), (high_1, high_2) = config["low_m"], config["high_m"]
            values += [float(each) for each in (p[0] - low_1, high_1 - p[0], p[1] - low_2, high_2 - p[1])]
        else:
            values.append(h_of_place(config, p - displacement(config.get("motion"), t_s)))
    return values


@pytest.mark.parametrize("model", ALL)
def test_h_of_every_kind_is_what_the_file_states(model: str) -> None:
    robot = robot_of(ALL[model])
    barriers = barriers_of(ALL[model], robot)
    core = ca.Function("h", [robot.system.x, robot.system.t], [ca.vertcat(*(barrier.h for barrier in barriers))])
    page = BarrierValues(ALL[model])
    files = [barrier.model_dump() for barrier in ALL[model].filter.barriers]
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, t_s = rng.uniform(-3, 3, robot.system.n), rng.uniform(0, 10)
        expected = [value for config in files for value in expected_h(config, model, x, t_s)]
        assert page.h(x.tolist(), t_s) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert page.h(x.tolist(), t_s) == core(x, t_s).full().ravel().tolist()
    assert [one.name for one in ALL[model].barriers] == [barrier.name for barrier in barriers]


@pytest.mark.parametrize("model", ["damped-point", "two-points"])
def test_displacement_of_every_motion_is_what_the_file_states(model: str) -> None:
    page, barriers = BarrierValues(ALL[model]), ALL[model].barriers
    moving = {moving_table(i): b for i, b in enumerate(barriers) if b.outline is not None and b.outline.motion}
    for t_s in (0.0, 0.7, 12.3):
        found = page.displacements_m(t_s)
        assert found.keys() == moving.keys()
        for table, barrier in moving.items():
            motion = barrier.outline and barrier.outline.motion
            assert motion is not None
            expected = displacement(motion.model_dump(), t_s)
            assert found[table] == pytest.approx(expected, rel=1e-12, abs=1e-12)
            assert motion.displacements_m(np.array([t_s]))[:, 0] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_barriers_keep_the_order_of_the_file_and_have_units() -> None:
    barriers = scenario("damped-point", 4, [WALL, DISK, ELLIPSE, SPEED]).barriers
    assert [type(one) for one in barriers] == [HalfPlaneBarrier, DiskBarrier, EllipseBarrier, SpeedBarrier]
    assert [one.name for one in barriers] == ["b0", "b1", "b2", "b3"]
    assert [one.h_unit for one in barriers] == ["m", "m²", "m²", "m²/s²"]


def test_limits_have_the_unit_of_their_coordinate() -> None:
    joints = scenario("joint-chain", 2, [limits("position", 1), limits("velocity", 1)]).barriers
    points = scenario("two-points", 8, [limits("position", 4), limits("velocity", 4), APART]).barriers
    assert [one.h_unit for one in joints] == ["rad", "rad", "rad/s", "rad/s"]
    assert [one.h_unit for one in points] == ["m"] * 8 + ["m/s"] * 8 + ["m²"]


def test_every_kind_has_a_word_of_its_own() -> None:
    words = [word for kind in BARRIER_KINDS for word in kind_words(kind)]
    assert len(words) == len(set(words))
    assert set(words) >= {"disk-keep-out", "disk-keep-in", "room", "keep-apart"}
