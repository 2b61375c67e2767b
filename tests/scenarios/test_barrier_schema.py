"""Schema of barriers in scenario files and its error messages."""

from typing import Any

import pytest
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario

NAME = "notomista-cai-2020"
CHAIN = [{"kind": "linear", "gain": 5.0}] * 3
DISK = {"kind": "disk-keep-out", "name": "a", "centre": [0, 0], "radius": 1, "class_k": CHAIN}
ELLIPSE = {"kind": "ellipse-keep-in", "name": "a", "centre": [0, 0], "semi_axes_m": [2, 1], "class_k": CHAIN}
WALL = {"kind": "half-plane", "name": "a", "normal": [1, 0], "offset": 0, "class_k": CHAIN}
ROOM = {"kind": "room", "name": "a", "low_m": [-3, -2], "high_m": [3, 2], "class_k": CHAIN}
SPEED = {"kind": "speed-limit", "name": "a", "limit_m_per_s": 2, "class_k": CHAIN[:2]}
LIMITS = {"kind": "coordinate-limits", "name": "a", "low": [-1, -2], "high": [1, 2], "class_k": CHAIN}
APART = {"kind": "keep-apart", "name": "a", "distance_m": 0.5, "class_k": CHAIN}
SWING = {"kind": "swing", "amplitude_m": [1, 0], "frequency_hz": 0.5}
CIRCLE = {"kind": "circle", "radius_m": 1, "frequency_hz": 0.5}
TRAVEL = {"kind": "travel", "velocity_m_per_s": [1, 0]}


def with_barriers(*barriers: dict[str, Any], model: str = "damped-point", states: int = 4) -> Scenario:
    plant = {"model": model, "x0": [0.5] * states}
    return load_scenario(NAME, {"filter.barriers": list(barriers), "plant": plant})


@pytest.mark.parametrize(
    ("barrier", "field", "allowed"),
    [
        (DISK | {"centre": [0]}, "centre", "a list no shorter than 2"),
        (DISK | {"centre": [0, 0, 0]}, "centre", "a list no longer than 2"),
        (DISK | {"radius": 0}, "radius", "above 0"),
        (DISK | {"point": 3}, "point", "at most 2"),
        (DISK | {"colour": "red"}, "colour", "kind, name, class_k, point, motion, centre, radius"),
        (DISK | {"motion": {"kind": "jump"}}, "motion.kind", "travel, swing, circle"),
        (DISK | {"motion": SWING | {"frequency_hz": 0}}, "motion.frequency_hz", "above 0"),
        (DISK | {"motion": CIRCLE | {"radius_m": -1}}, "motion.radius_m", "above 0"),
        (DISK | {"motion": TRAVEL | {"velocity_m_per_s": [1]}}, "motion.velocity_m_per_s", "a list no shorter than 2"),
        (ELLIPSE | {"semi_axes_m": [1, 0]}, "semi_axes_m.1", "above 0"),
        (ELLIPSE | {"semi_axes_m": [1]}, "semi_axes_m", "a list no shorter than 2"),
        (WALL | {"normal": [0, 0]}, "normal", "a vector that is not zero"),
        (WALL | {"offset": float("inf")}, "offset", "finite number"),
        (ROOM | {"high_m": [3, -2]}, "low_m, high_m", "every high above its low"),
        (LIMITS | {"low": [-1]}, "low, high", "as many numbers in both"),
        (LIMITS | {"of": "force"}, "of", "'position' or 'velocity'"),
        (SPEED | {"limit_m_per_s": 0}, "limit_m_per_s", "above 0"),
        (APART | {"distance_m": -1}, "distance_m", "above 0"),
        ({"kind": "fence", "name": "a"}, "kind", "keep-apart"),
    ],
)
def test_a_field_that_holds_what_it_may_not_is_named(barrier: dict[str, Any], field: str, allowed: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        with_barriers(barrier)

    assert refused.value.field == f"filter.barriers.0.{field}"
    assert allowed in refused.value.allowed


@pytest.mark.parametrize(
    ("barriers", "model", "states", "words"),
    [
        ([APART], "damped-point", 4, ("'a'", "keep-apart", "2 or more points")),
        ([DISK | {"point": 2}], "damped-point", 4, ("point 2 of barrier 'a'", "allowed 1 to 1")),
        ([DISK], "joint-chain", 4, ("'disk-keep-out'", "'joint-chain'", "1 or more points")),
        ([SPEED], "joint-chain", 4, ("'speed-limit'", "1 or more points")),
        ([ROOM, DISK | {"name": "a top"}], "damped-point", 4, ("'a top'", "each name once")),
        ([DISK, DISK | {"name": "a 1", "point": 1}], "two-points", 8, ("'a 1'", "each name once")),
        ([LIMITS, DISK | {"name": "a 2 high"}], "damped-point", 4, ("'a 2 high'", "each name once")),
    ],
)
def test_barriers_of_other_models_and_shared_names_are_refused(
    barriers: list[dict[str, Any]], model: str, states: int, words: tuple[str, ...]
) -> None:
    with pytest.raises(ScenarioError) as refused:
        with_barriers(*barriers, model=model, states=states)

    assert all(word in str(refused.value) for word in words)


def test_a_barrier_of_one_point_keeps_its_name() -> None:
    barriers = [DISK | {"name": "both"}, DISK | {"name": "second", "point": 2}, APART]
    single = with_barriers(*barriers, model="two-points", states=8).barriers

    assert [(one.name, getattr(one, "point", None)) for one in single] == [
        ("both 1", 1),
        ("both 2", 2),
        ("second", 2),
        ("a", None),
    ]


def test_room_is_four_walls_and_each_coordinate_has_two_limits() -> None:
    single = with_barriers(ROOM | {"name": "room"}, LIMITS | {"name": "joint"}).barriers

    assert [one.name for one in single] == [
        *("room left", "room right", "room bottom", "room top"),
        *("joint 1 low", "joint 1 high", "joint 2 low", "joint 2 high"),
    ]
    assert [one.class_k for one in single] == [single[0].class_k] * 8


def test_a_scenario_with_every_kind_survives_json() -> None:
    scenario = with_barriers(
        ROOM,
        DISK | {"name": "b", "motion": SWING},
        ELLIPSE | {"name": "c", "motion": CIRCLE},
        WALL | {"name": "d", "motion": TRAVEL},
    )

    assert Scenario.model_validate_json(scenario.model_dump_json()) == scenario
    assert hash(scenario.barriers) == hash(scenario.barriers)
