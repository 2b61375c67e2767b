"""The drive sheet over a running demo: driving, a bad network, the emergency stop, taking over, a killed filter."""

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from running_demo import RunningDemo, running_demo
from watched_page import ARGUMENTS, CHROMIUM, Watched, open_browser

pytestmark = [pytest.mark.live, pytest.mark.browser, pytest.mark.alone]

PAD_PX = 150
REACH_PX = PAD_PX / 2 - 20
"""Way of the stick's knob."""

ATTEMPTS = 4
ATTEMPT_MS = 15_000

GAMEPAD = """
const pressed = (on) => ({ pressed: on, touched: on, value: on ? 1 : 0 });
globalThis.pad = { axes: [0, 0, 0, 0], held: [] };
const buttons = () => Array.from({ length: 16 }, (_, i) => pressed(pad.held.includes(i)));
navigator.getGamepads = () => [{ axes: pad.axes, buttons: buttons() }];
"""


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    options = ("--scenario", "walls-and-disks", "--rate", "250", "--restart")
    with running_demo(tmp_path_factory.mktemp("runs"), *options) as running:
        running.wait_for("running")
        yield running


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with open_browser() as started:
        yield started


class DrivenPage(Watched):
    """The drive sheet with hands on it."""

    def __init__(self, browser: Any, demo: RunningDemo) -> None:  # noqa: ANN401 - playwright's
        super().__init__(browser)
        self.late: type[Exception] = pytest.importorskip("playwright.sync_api").TimeoutError
        self.page.set_viewport_size({"width": 1366, "height": 768})
        self.page.add_init_script(GAMEPAD)
        address = demo.wait_for(r"^dashboard http").split()[1]
        self.page.goto(address)
        self.wait_for("document.getElementById('connection').textContent === 'live'")

    def take(self) -> None:
        """Take the controls and wait for the operator to follow."""
        self.page.click("#take")
        self.wait_for("document.getElementById('lease').textContent.startsWith('held by page')")
        self.wait_for("document.getElementById('take').textContent === 'Give back the controls'")

    def drag(self, right: float, up: float) -> None:
        """Drag the stick by shares of its way and hold it there."""
        box = self.page.locator("#pad-0").bounding_box()
        middle = box["x"] + PAD_PX / 2, box["y"] + PAD_PX / 2
        self.page.mouse.move(*middle)
        self.page.mouse.down()
        self.page.mouse.move(middle[0] + right * REACH_PX, middle[1] - up * REACH_PX, steps=4)

    def hold_buttons(self, *held: int) -> None:
        """Hold these buttons of the gamepad, let go of the others, and wait until the page has read them."""
        self.page.evaluate(f"pad.held = {list(held)}")
        self.wait_for(f"passafePage.steering.engaged === {'true' if held else 'false'}")

    def wait_for_words(self, begin: str, timeout_ms: int = 60_000) -> None:
        """Wait for the status in words."""
        shown = f"document.getElementById('headline').textContent.startsWith('{begin}')"
        self.page.wait_for_function(f"() => {shown}", timeout=timeout_ms)

    def steer_until(self, begin: str, engage: Callable[[], None], let_go: Callable[[], None]) -> None:
        """Steer until the status says so; let go and engage again as the page asks where it stalled.

        A command drives for 250 ms: after a longer pause of the browser, as on a loaded machine, the operator counts
        no more of them before the dead-man was let go.
        """
        for _ in range(ATTEMPTS):
            engage()
            try:
                self.wait_for_words(begin, timeout_ms=ATTEMPT_MS)
            except self.late:
                let_go()
            else:
                return
        shown = [self.text(f"#{part}") for part in ("headline", "drive-hint", "driver", "lease", "take")]
        raise AssertionError(f"{ATTEMPTS} times {ATTEMPT_MS} ms without {begin!r}; the page shows {shown}")


@pytest.fixture
def sheet(browser: Any, demo: RunningDemo) -> Iterator[DrivenPage]:  # noqa: ANN401 - playwright's
    opened = DrivenPage(browser, demo)
    yield opened
    opened.page.close()


def test_the_stick_drives_into_a_disk_and_the_robot_is_held(sheet: DrivenPage) -> None:
    full = sheet.page.evaluate("passafePage.setup.drive.full")
    sheet.take()
    share = -4.0 / full[0], 2.4 / full[1]  # the robot's spring of 4 N/m lets it rest at (-1, 0.6), the disk's centre
    sheet.steer_until("Held back by “left”", lambda: sheet.drag(*share), sheet.page.mouse.up)
    sheet.wait_for("passafePage.drive.gaps.rows[4].item.className === 'nearest'")
    assert sheet.page.evaluate("parseFloat(document.querySelectorAll('#gaps .value')[4].textContent)") >= 0
    sheet.page.mouse.up()
    sheet.wait_for("document.getElementById('driver').textContent === 'you, from this page'")
    sheet.page.click("#take")
    sheet.wait_for("document.getElementById('driver').textContent === 'nobody'")
    assert sheet.complaints == []


def test_a_gamepad_steers_only_while_its_dead_man_is_held(sheet: DrivenPage) -> None:
    sheet.take()
    sheet.page.evaluate("pad.axes = [1, 0, 0, 0]")
    sheet.wait_for("!passafePage.steering.engaged")
    sheet.page.evaluate("pad.held = [5]")
    sheet.wait_for("passafePage.steering.engaged && passafePage.steering.values[0][0] > 0.9")
    sheet.steer_until("Held back by", lambda: sheet.hold_buttons(5), sheet.hold_buttons)
    sheet.page.evaluate("pad.held = [1]")
    sheet.wait_for_words("Emergency stop")
    sheet.page.on("dialog", lambda dialog: dialog.accept())
    sheet.page.click("#clear")
    sheet.wait_for("document.getElementById('clear').hidden")


def test_a_second_page_takes_over_only_when_it_says_so(browser: Any, sheet: DrivenPage, demo: RunningDemo) -> None:  # noqa: ANN401 - playwright's
    # A browser of its own: a page in the background gives the controls back by itself
    elsewhere = browser.browser_type.launch(executable_path=CHROMIUM, args=ARGUMENTS)
    other = DrivenPage(elsewhere, demo)
    sheet.take()
    other.wait_for("document.getElementById('take').textContent.startsWith('Take over from page')")
    other.take()
    sheet.wait_for(
        "document.getElementById('drive-hint').textContent.startsWith('The controls are gone: taken by page')"
    )
    assert sheet.text("#take").startswith("Take over from page")
    elsewhere.close()
    sheet.wait_for("document.getElementById('driver').textContent === 'nobody'")


def test_a_slow_network_is_seen_in_the_delays(sheet: DrivenPage) -> None:
    sheet.page.click("#script")
    sheet.page.fill("input[aria-label='delay robot → filter']", "55")
    sheet.wait_for("document.getElementById('panel-answer').textContent === 'acknowledged: robot → filter'")
    sheet.wait_for("parseFloat(document.getElementById('from-robot').textContent) >= 300")
    sheet.wait_for("parseFloat(document.getElementById('round-trip').textContent) >= 300")
    sheet.page.click("text=Perfect network")
    sheet.wait_for("parseFloat(document.getElementById('from-robot').textContent) < 100")


def test_the_stop_works_with_a_frozen_filter(sheet: DrivenPage, demo: RunningDemo) -> None:
    filter_ = demo.children()["filter"]
    os.kill(filter_, signal.SIGSTOP)
    try:
        sheet.wait_for_words("Nothing new arrives")
        assert "filter" in sheet.text("#detail")
        sheet.page.click("#stop")
        sheet.wait_for_words("Emergency stop")
    finally:
        os.kill(filter_, signal.SIGCONT)
    sheet.page.on("dialog", lambda dialog: dialog.accept())
    sheet.page.click("#clear")
    sheet.wait_for("document.getElementById('clear').hidden")


def test_a_killed_filter_is_named_and_comes_back(sheet: DrivenPage) -> None:
    sheet.page.click("#tab-processes")
    sheet.page.click("button[aria-label='kill filter']")
    sheet.wait_for("document.getElementById('detail').textContent.includes('filter')")
    sheet.wait_for("document.getElementById('connection').textContent === 'live'")


def test_another_scenario_runs_without_reloading_the_page(sheet: DrivenPage, tmp_path: Path) -> None:
    sheet.page.evaluate("globalThis.stayed = true")
    sheet.page.click("#tab-run")
    sheet.page.select_option("select[name=scenario]", "moving-disk")
    sheet.page.check("input[name=mode][value=safe]")
    sheet.page.click("text=Start a new run")
    sheet.wait_for("document.querySelector('h1').textContent === 'A disk that comes and goes'")
    sheet.wait_for("document.getElementById('mode').textContent === 'safe'")
    sheet.wait_for("document.getElementById('connection').textContent === 'live'")
    assert sheet.page.evaluate("globalThis.stayed")
    sheet.page.screenshot(path=tmp_path / "sheet.png")
