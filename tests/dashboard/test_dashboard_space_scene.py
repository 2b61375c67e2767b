"""The live scene of a robot in space."""

from passafe_dashboard.live.scene_setup import live_scene
from passafe_services.scenarios.load import load_scenario


def test_an_arm_is_shown_among_what_it_keeps_off() -> None:
    scene = live_scene(load_scenario("arm-over-table"))

    assert scene["kind"] == "space"
    assert {ball["name"]: ball["centre"] for ball in scene["balls"]} == {
        "post": (0.15, -0.42, 0.62),
        "ball": (0.55, 0.32, 0.35),
    }
    assert scene["levels"] == [{"name": "table", "height_m": 0.0}]
    low, high = scene["bounds"]
    assert all(low[i] < ball["centre"][i] < high[i] for ball in scene["balls"] for i in range(3))
    assert low[2] < 0.0
