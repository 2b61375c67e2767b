from math import pi

import pytest
from closed_form import header, tick
from closed_form import state as closed_form_state
from msgspec.structs import replace
from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.live_charts import live_charts
from passafe_dashboard.live.page_state import page_state
from passafe_dashboard.live.scene_setup import live_scene
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.scenarios.load import load_scenario

JOINTS = {
    "plant.model": "joint-chain",
    "plant.x0": [0.1, 0.2, 0.0, 0.0],
    "plant.parameters": {},
    "filter.barriers": [],
}


def test_view_of_a_room_ends_at_its_walls() -> None:
    assert live_scene(load_scenario("walls-and-disks"))["bounds"] == ((-3.0, -2.0), (3.0, 2.0))


def test_view_of_an_open_plane_has_room_around_disk_and_start() -> None:
    assert live_scene(load_scenario("notomista-cai-2020"))["bounds"] == ((-2.5, -2.5), (2.5, 2.5))


def test_view_holds_a_disk_wherever_it_swings() -> None:
    scene = live_scene(load_scenario("moving-disk", {"filter.barriers.0.motion.amplitude_m": [4.0, 0.0]}))
    assert scene["bounds"][1][0] == pytest.approx(4.5, abs=1e-3)
    assert scene["bounds"][0][0] == pytest.approx(-4.5, abs=1e-3)


def test_scene_of_joints_has_no_plane() -> None:
    scene = live_scene(
        load_scenario("human-steers", JOINTS | {"operator.source": {"kind": "constant", "value": [0.0, 0.0]}})
    )
    assert scene["kind"] == "joints"
    assert [joint["name"] for joint in scene["joints"]] == ["joint 1", "joint 2"]
    assert "bounds" not in scene


def test_a_chart_reads_only_columns_that_frames_have() -> None:
    layout = ColumnLayout.of(load_scenario("walls-and-disks"))
    plans = live_charts(layout)
    assert [plan.key for plan in plans] == ["status", "h", "chain", "power", "tank", "ages"]
    columns = {"ticks": set(layout.tick_columns), "states": set(layout.state_columns)}
    for plan in plans:
        assert all(line.column in columns[line.table] for line in plan.lines)
    assert plans[2].choices == layout.names


def test_a_scenario_without_barriers_has_no_charts_of_them() -> None:
    assert [plan.key for plan in live_charts(ColumnLayout(barriers=(), levels=()))] == [
        "status",
        "power",
        "tank",
        "ages",
    ]


def test_scene_of_a_car_has_its_body() -> None:
    scene = live_scene(load_scenario("unicycle-posts"))
    assert scene["heading"] == "q_2"
    assert len(scene["outline"]) == 5
    assert scene["arrows"] is False


def test_frames_of_a_car_have_the_place_of_its_body() -> None:
    layout = ColumnLayout.of(load_scenario("unicycle-posts"))
    assert layout.state_values(state(1.0, 2.0, 0.5, 0.0, 0.0), []) == [1.0, 2.0]


def test_state_of_a_car_is_shown_with_its_heading_and_pushes() -> None:
    """Ahead is up: a force forward pushes up, one of turning to the left."""
    feed = Feed(load_scenario("unicycle-posts"))
    feed.push(header("plant", 1), state(1.0, 2.0, pi / 2, 0.5, 0.0), 0)
    ahead = tick(1)
    ahead = replace(ahead, x_hat=(1.0, 2.0, pi / 2, 0.5, 0.0), u_h=(2.0, 0.0), u=(2.0, 10.0), u_nominal=(2.0, 0.0))
    feed.push(header("filter", 1), ahead, 0)

    shown = page_state(feed, 0)
    assert (shown["plant"]["places"], shown["plant"]["heading"]) == ([(1.0, 2.0)], pi / 2)
    assert shown["plant"]["velocities"][0] == pytest.approx((0.0, 0.5))
    assert shown["filter"]["pushes"]["asked"] == pytest.approx((0.0, 2.0))
    assert shown["filter"]["pushes"]["allowed"] == pytest.approx((-3.0, 2.0))


def state(*x: float) -> PlantState:
    return replace(closed_form_state(1), x=x, phase=PlantPhase.RUNNING)
