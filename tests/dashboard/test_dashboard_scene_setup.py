import pytest
from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.live.live_charts import live_charts
from passafe_dashboard.live.scene_setup import live_scene
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
