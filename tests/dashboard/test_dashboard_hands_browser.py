"""Hands on the live page in a real browser that do what nobody planned."""

from collections.abc import Iterator
from typing import Any

import pytest
from closed_form import paper_scenario
from passafe_dashboard.live.feed import Feed
from served_page import FastRun, serve_page
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser

GAMEPAD = """
const button = (on) => ({ pressed: on, touched: on, value: on ? 1 : 0 });
globalThis.held = null;
const buttons = () => Array.from({ length: 16 }, (_, i) => button(held.includes(i)));
navigator.getGamepads = () => [held && { axes: [1, 0, 0, 0], buttons: buttons() }];
"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with open_browser() as started:
        yield started


@pytest.fixture
def driving(browser: Any) -> Iterator[Watched]:  # noqa: ANN401 - playwright's
    opened = Watched(browser)
    opened.page.add_init_script(GAMEPAD)
    with serve_page(FastRun(Feed(paper_scenario()), speed=1.0, frame_hz=30.0)) as served:
        opened.page.goto(served.url)
        opened.wait_for("passafePage.steering.socket.usable")
        take(opened)
        yield opened
        opened.page.close()


def take(watched: Watched) -> None:
    """Take the controls."""
    watched.page.evaluate("passafePage.steering.socket.take(true)")
    watched.wait_for("passafePage.steering.you")


def is_pushed(direction: str = ">") -> str:
    return f"passafePage.steering.engaged && passafePage.steering.values[0][0] {direction} 0"


STILL = "!passafePage.steering.engaged && passafePage.steering.values[0][0] === 0"


def test_key_that_comes_up_under_control_lets_go(driving: Watched) -> None:
    keyboard = driving.page.keyboard
    keyboard.down("ArrowRight")
    driving.wait_for(is_pushed())
    keyboard.down("Control")
    driving.wait_for(STILL)
    keyboard.up("ArrowRight")
    keyboard.up("Control")
    driving.wait_for(STILL)
    keyboard.down("ArrowLeft")
    driving.wait_for(is_pushed("<"))


def test_clutch_held_while_the_focus_is_lost_is_off_again(driving: Watched) -> None:
    keyboard = driving.page.keyboard
    keyboard.down("ArrowRight")
    keyboard.down("Shift")
    driving.wait_for("passafePage.steering.isClutched")
    driving.page.evaluate("window.dispatchEvent(new Event('blur'))")
    driving.wait_for("!passafePage.steering.you")
    assert driving.page.get_attribute("#clutch", "aria-pressed") == "false"
    take(driving)
    keyboard.up("ArrowRight")
    keyboard.down("ArrowRight")
    driving.wait_for(is_pushed())


def test_gamepad_that_goes_while_pushed_lets_go(driving: Watched) -> None:
    driving.page.evaluate("held = [5]")
    driving.wait_for(is_pushed())
    driving.page.evaluate("held = [4, 5]")
    driving.wait_for("passafePage.steering.isClutched")
    driving.page.evaluate("held = null")
    driving.wait_for(STILL)
    assert not driving.page.evaluate("passafePage.steering.isClutched")
    driving.page.keyboard.down("ArrowLeft")
    driving.wait_for(is_pushed("<"))


def test_drag_goes_on_outside_of_the_window_and_ends_there(driving: Watched) -> None:
    box = driving.page.locator("#pad-0").bounding_box()
    mouse = driving.page.mouse
    mouse.move(box["x"] + 75, box["y"] + 75)
    mouse.down()
    mouse.move(-400, box["y"] + 75)
    driving.wait_for(is_pushed("<"))
    mouse.up()
    driving.wait_for(STILL)
