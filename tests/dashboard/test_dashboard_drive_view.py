import pytest
from closed_form import header, paper_scenario, state, tick
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.page_state import page_state
from passafe_protocol.messages import RowReport
from passafe_services.scenarios.load import load_scenario

RIGHT = (2.0, 0.0, 0.0, 0.0)


def test_gaps_have_distance_text_and_the_nearest_is_marked() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0, x=RIGHT), 0)
    [gap] = page_state(feed, 0)["gaps"]
    assert gap["distance"] == pytest.approx(1.0)
    assert (gap["text"], gap["nearest"], gap["h"]) == ("1.0 m", True, 3.0)
    feed.push(header("plant", 1), state(5, x=(0.5, 0.0, 0.0, 0.0)), 0)
    [gap] = page_state(feed, 0)["gaps"]
    assert gap["text"] == "−50 cm"
    feed.push(header("plant", 2), state(100, x=RIGHT), 0)
    assert page_state(feed, 0)["gaps"][0]["lowest_h"] == -0.75


def test_held_directions_are_those_of_the_decision() -> None:
    feed = Feed(paper_scenario())
    rows = (RowReport("disk", 1.5, 0.0, False), RowReport("passivity", 0.0, 0.0, False))
    feed.push(header("filter", 0), tick(0, x_hat=(0.0, 2.0, 0.0, 0.0), rows=rows), 0)
    [held] = page_state(feed, 0)["held"]
    assert (held["name"], held["point"]) == ("disk", 0)
    assert held["margin"] == pytest.approx(1.5)
    assert held["towards"] == pytest.approx((0.0, -1.0))


def test_energy_is_the_tank_where_there_is_one() -> None:
    feed = Feed(load_scenario("moving-disk"))
    feed.push(header("filter", 0), tick(0, tank_j=0.75, mode="safe"), 0)
    assert page_state(feed, 0)["energy"] == {
        "kind": "tank",
        "asked": False,
        "level_j": 0.75,
        "reserve_j": 0.5,
        "max_j": 10.0,
    }
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), tick(0, power_margin=0.25), 0)
    assert page_state(feed, 0)["energy"] == {"kind": "power", "asked": True, "margin_w": 0.25}
