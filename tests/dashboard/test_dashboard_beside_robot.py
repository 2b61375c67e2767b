"""Pages of logs and experiments beside a robot: they say what it does, and stop it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from closed_form import paper_scenario
from closed_form_log import circle_messages, write_log
from passafe_dashboard.live.feed import Feed
from served_page import FastRun, ServedPage, serve_page
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser

PAGES = ["/logs", "/logs/circle.mcap", "/experiments", "/compare?log=circle.mcap&log=circle.mcap"]

GAMEPAD = """() => {
  const buttons = Array.from({ length: 17 }, (_, i) => ({ pressed: i === 1, value: Number(i === 1) }));
  navigator.getGamepads = () => [{ axes: [0, 0, 0, 0], buttons, connected: true, id: "synthetic", index: 0 }];
}"""


@pytest.fixture
def run(tmp_path: Path) -> FastRun:
    made = FastRun(Feed(paper_scenario()), speed=1.0, frame_hz=30.0)
    write_log(tmp_path / "circle.mcap", circle_messages(200))
    made.runs = tmp_path
    return made


@pytest.fixture
def served(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run) as page:
        yield page


@pytest.fixture
def watched() -> Iterator[Watched]:
    with open_browser() as browser:
        yield Watched(browser)


@pytest.mark.parametrize("how", ["click", "key", "gamepad"])
def test_the_robot_is_stopped_from_a_list_of_logs(watched: Watched, served: ServedPage, run: FastRun, how: str) -> None:
    watched.page.goto(f"{served.url}/logs")
    watched.wait_for("['free', 'held'].includes(document.getElementById('robot').dataset.tone)")
    assert watched.page.get_attribute("#robot", "href") == "/#drive"
    if how == "click":
        watched.page.click("#stop")
    elif how == "key":
        watched.page.keyboard.press("Escape")
    else:
        watched.page.evaluate(GAMEPAD)
    watched.wait_for("document.getElementById('robot').textContent === 'Emergency stop'")
    assert run.latch.is_latched
    assert len(run.stop_requests) == 1
    assert watched.page.is_visible("#clear")
    assert watched.complaints == []


@pytest.mark.parametrize("width", [390, 1024, 1440])
@pytest.mark.parametrize("path", PAGES)
def test_what_the_robot_does_is_in_every_frame(watched: Watched, served: ServedPage, path: str, width: int) -> None:
    watched.page.set_viewport_size({"width": width, "height": 800})
    watched.page.goto(f"{served.url}{path}")
    watched.wait_for("document.getElementById('robot').dataset.tone")
    line, stop = (watched.page.locator(name).bounding_box() for name in ("#robot", "#stop"))
    assert line["width"] >= 250
    assert stop["x"] + stop["width"] <= width
    assert line["x"] + line["width"] <= stop["x"] or line["y"] >= stop["y"] + stop["height"]
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= width
    assert watched.axe_faults() == []


def test_silence_of_the_dashboard_is_named(watched: Watched, run: FastRun) -> None:
    with serve_page(run) as served:
        watched.page.goto(f"{served.url}/experiments")
        watched.wait_for("document.getElementById('robot').dataset.tone")
    watched.wait_for("document.getElementById('robot').textContent === 'The dashboard does not answer'")
