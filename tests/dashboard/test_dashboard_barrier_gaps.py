from math import hypot, pi

import casadi as ca
import pytest
from own_robots import car_with_a_hitch, scenario_of
from passafe_dashboard.live.barrier_gaps import BarrierGaps, Gap
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario

PULL = {"kind": "constant", "value": [1.0]}


def with_barriers(scenario: str, *barriers: dict[str, object]) -> Scenario:
    gains = [{"kind": "linear", "gain": 5.0}] * 3
    return load_scenario(scenario, {"filter.barriers": [{"class_k": gains} | barrier for barrier in barriers]})


def gaps(scenario: Scenario, *x: float, t_s: float = 0.0) -> dict[str, Gap]:
    return {gap.name: gap for gap in BarrierGaps(scenario).read(x, t_s)}


@pytest.mark.parametrize(
    ("place", "distance"), [((2.0, 0.0), 1.5), ((0.5, 0.0), 0.0), ((0.0, 0.1), -0.4), ((0.0, 0.0), -0.5)]
)
def test_gap_to_a_disk_is_its_distance(place: tuple[float, float], distance: float) -> None:
    disk = {"kind": "disk-keep-out", "name": "disk", "centre": [0.0, 0.0], "radius": 0.5}
    gap = gaps(with_barriers("notomista-cai-2020", disk), *place, 0.0, 0.0)["disk"]
    assert gap.distance == pytest.approx(distance, abs=1e-5)
    assert gap.unit == "m"


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0, 0.0), (0.6, -0.8)])
def test_gap_inside_a_disk_to_stay_in(place: tuple[float, float]) -> None:
    arena = {"kind": "disk-keep-in", "name": "arena", "centre": [0.0, 0.0], "radius": 2.0}
    gap = gaps(with_barriers("notomista-cai-2020", arena), *place, 0.0, 0.0)["arena"]
    assert gap.distance == pytest.approx(2.0 - hypot(*place), abs=1e-5)


def test_gaps_point_at_walls_and_disks() -> None:
    found = gaps(load_scenario("walls-and-disks"), -2.0, -1.0, 0.0, 0.0)
    assert found["room left"].distance == pytest.approx(1.0)
    assert found["room left"].towards == pytest.approx((-1.0, 0.0))
    assert found["room top"].towards == pytest.approx((0.0, 1.0))
    assert found["left"].distance == pytest.approx(hypot(1.0, 1.6) - 0.5)
    assert found["left"].towards == pytest.approx((1.0 / hypot(1.0, 1.6), 1.6 / hypot(1.0, 1.6)))


def test_gap_of_a_moving_disk_is_that_of_its_place_now() -> None:
    scenario = load_scenario("moving-disk")  # 1.5 m to the right after a second
    assert gaps(scenario, 3.0, 0.0, 0.0, 0.0, t_s=1.0)["visitor"].distance == pytest.approx(1.0)
    assert gaps(scenario, 3.0, 0.0, 0.0, 0.0, t_s=3.0)["visitor"].distance == pytest.approx(4.0)


def test_gap_to_a_speed_limit_is_the_speed_left() -> None:
    for velocity in ((0.6, 0.8), (0.0, 0.0)):
        gap = gaps(load_scenario("tight-limits"), 0.0, -1.0, *velocity)["speed"]
        assert gap.distance == pytest.approx(2.0 - hypot(*velocity))
        assert gap.unit == "m/s"


def test_gap_between_two_robots_is_the_way_left_to_the_first() -> None:
    found = gaps(load_scenario("two-robots"), -1.0, 0.0, 1.0, 0.0, *[0.0] * 4)
    assert found["apart"].distance == pytest.approx(1.4)
    assert found["apart"].towards == pytest.approx((1.0, 0.0))
    assert found["apart"].pulls[0] == pytest.approx((0.5**0.5, 0.0))
    assert found["apart"].pulls[1] == pytest.approx((-(0.5**0.5), 0.0))
    assert [found[f"room {i} left"].point for i in (1, 2)] == [0, 1]
    assert found["room 2 right"].distance == pytest.approx(2.0)


def test_a_scenario_without_barriers_has_no_gaps() -> None:
    assert BarrierGaps(with_barriers("notomista-cai-2020")).read((0.0,) * 4, 0.0) == []


def test_gaps_of_body_spheres_are_distances_in_space() -> None:
    scenario = load_scenario("arm-over-table")
    robot = robot_of(scenario)
    tip = next(sphere for sphere in robot.spheres if sphere.name == "tip")
    x0 = list(scenario.plant.x0)
    height = float(ca.Function("z", [robot.system.x], [tip.centre[2]])(x0)) - tip.radius_m
    table = next(single for single in scenario.barriers if single.name == "table: tip")

    found = {gap.name: gap for gap in BarrierGaps(scenario).read(x0, 0.0)}

    assert found["table: tip"].distance == pytest.approx(height - table.height_m)
    assert {gap.unit for name, gap in found.items() if name.startswith(("table", "post"))} == {"m"}


def test_one_joint_has_a_gap_to_each_limit() -> None:
    limits = {"kind": "coordinate-limits", "name": "q", "low": [-0.5], "high": [1.5]}
    joint = {"plant.model": "joint-chain", "plant.x0": [0.2, 0.0], "operator.source": PULL}
    gains = [{"kind": "linear", "gain": 5.0}] * 3
    scenario = load_scenario("notomista-cai-2020", joint | {"filter.barriers": [{"class_k": gains} | limits]})

    found = gaps(scenario, 0.2, 0.0)
    assert [found["q 1 low"].distance, found["q 1 high"].distance] == pytest.approx([0.7, 1.3])


def test_gaps_of_a_car_are_those_of_its_nose() -> None:
    """Nose 0.3 m ahead of the place; the hitch is of no quantity, and its gap is h."""
    scenario = scenario_of(car_with_a_hitch(), [0.0, 0.0, pi / 2, 0.4, 0.0], [0.0, 0.0])

    found = gaps(scenario, 0.0, 0.0, pi / 2, 0.4, 0.0)
    assert found["post"].distance == pytest.approx(1.7 - 0.5)
    assert found["post"].towards == pytest.approx((0.0, 1.0))
    assert (found["hitch"].distance, found["hitch"].unit, found["hitch"].towards) == (0.5, "", (0.0, 0.0))
    assert (found["speed"].distance, found["speed"].unit) == (pytest.approx(1.0), "m/s")
