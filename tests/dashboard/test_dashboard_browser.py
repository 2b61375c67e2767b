"""The live page in a real browser."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from closed_form import h, paper_scenario
from passafe_dashboard.live.feed import Feed
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import BarrierReport, FilterStatus
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from served_page import FastRun, ServedPage, serve_page
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser

LIVE = "document.getElementById('connection').textContent === 'live'"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with open_browser() as started:
        yield started


@pytest.fixture
def watched(browser: Any) -> Iterator[Watched]:  # noqa: ANN401 - playwright's
    opened = Watched(browser)
    yield opened
    opened.page.close()


@pytest.fixture
def run() -> FastRun:
    return FastRun(Feed(paper_scenario()), speed=3.0, frame_hz=30.0)


@pytest.fixture
def served(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run) as page:
        yield page


def rows_of(table: str, column: str) -> str:
    """JavaScript for a column of a table of the page, numbers only."""
    return f"[...passafePage.tables.{table}.envelope('{column}').low].filter(Number.isFinite)"


def is_text(element: str, text: str) -> str:
    return f"document.getElementById('{element}').textContent === '{text}'"


def test_the_drive_sheet_says_what_holds_the_robot(watched: Watched, served: ServedPage, tmp_path: Path) -> None:
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    watched.wait_for("parseFloat(document.getElementById('plant-time').textContent) > 7")
    assert watched.page.is_hidden("#banner")
    watched.wait_for("document.getElementById('headline').textContent.startsWith('Held back by “disk”')")
    assert watched.text("#detail") == "62 % of the command would pass unchanged."
    assert watched.text("#mode") == "safe and passive"
    [bar] = watched.page.locator("#gaps li").all()
    assert bar.get_attribute("class") == "nearest"
    assert bar.locator(".name").text_content() == "disk"
    assert str(bar.locator(".value").text_content()).split()[1] in ("cm", "m")
    assert watched.text("#recording") == "on"
    drawn = watched.page.evaluate(rows_of("states", "h_0"))
    assert min(drawn) >= 0.44 - 1e-6
    assert max(drawn) <= h(0.0) + 1e-6
    watched.page.screenshot(path=tmp_path / "live.png")
    assert watched.complaints == []
    assert all(url.startswith((served.url, "data:", f"ws://{served.host}")) for url in watched.requests)


def test_the_engineers_sheet_has_every_number(watched: Watched, served: ServedPage) -> None:
    watched.page.goto(f"{served.url}/#engineer")
    watched.wait_for("document.getElementById('barriers').rows.length === 1")
    watched.wait_for("parseFloat(document.getElementById('plant-time').textContent) > 7")
    watched.wait_for("document.getElementById('barriers').rows[0].cells[2].textContent === '0.4400'")
    assert watched.text("#status") in ("PASSED", "MODIFIED")
    assert float(watched.text("#power-margin").split()[0]) > 0
    assert watched.page.locator("#rows tr").first.locator("td").first.text_content() == "active"
    assert watched.text("#state-age") == "1 ms"
    assert watched.text("#held-back").split()[0] == "5.000"
    assert watched.text("#allowed") == "62 %"
    assert watched.text("#infeasibility") == "12.50"
    assert "plant" in watched.page.locator("#processes th").all_text_contents()
    assert watched.page.locator("#charts canvas").count() == 6
    watched.page.click("nav [data-sheet=drive]")
    assert watched.page.is_visible("#drive-sheet")
    assert watched.page.is_hidden("#engineer-sheet")
    assert watched.complaints == []


def test_a_scene_in_which_nothing_moves_is_hardly_drawn(watched: Watched, served: ServedPage, run: FastRun) -> None:
    counter = "const draw = CanvasRenderingContext2D.prototype.clearRect; globalThis.cleared = 0;"
    counter += "CanvasRenderingContext2D.prototype.clearRect = function (...a) { cleared += 1; draw.apply(this, a); };"
    watched.page.add_init_script(counter)
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    run.speed = 0.0
    watched.wait_for("document.getElementById('scene-age').textContent.includes('No message')")
    watched.page.evaluate("cleared = 0, globalThis.before = passafePage.drawn")
    watched.wait_for("passafePage.drawn - before >= 40")
    assert watched.page.evaluate("cleared / (passafePage.drawn - before)") < 0.7  # its age in words, ten times a second


def test_dip_of_one_tick_is_shown_on_the_page(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(f"{served.url}/#engineer")
    watched.wait_for(f"globalThis.passafePage && {rows_of('ticks', 'psi_0_0')}.length > 5")

    run.next_tick = {"power_margin": -0.01}
    watched.wait_for(is_text("power-margin-worst", "−0.01000 W"))
    assert "negative" not in str(watched.page.get_attribute("#power-margin-worst", "class"))
    run.next_tick = {
        "power_margin": -3.5,
        "barriers": (BarrierReport("disk", (-0.25, -1.0, -2.0)),),
        "status": FilterStatus.INFEASIBLE,
    }
    watched.wait_for(is_text("power-margin-worst", "−3.500 W"))
    watched.wait_for("document.getElementById('power-margin-worst').classList.contains('negative')")
    watched.wait_for(f"Math.min(...{rows_of('ticks', 'psi_0_0')}) === -0.25")
    watched.wait_for(f"Math.max(...{rows_of('ticks', 'status')}) === {FilterStatus.INFEASIBLE.severity}")
    watched.wait_for("document.querySelector('[data-count=INFEASIBLE]').textContent === '1'")
    assert watched.complaints == []


def test_colours_follow_what_is_required(watched: Watched) -> None:
    run = FastRun(Feed(load_scenario("moving-disk")), speed=3.0, frame_hz=30.0)  # its tank is required, no power margin
    with serve_page(run) as served:
        watched.page.goto(f"{served.url}/#engineer")
        watched.wait_for("document.getElementById('tank-worst').textContent.endsWith(' J')")
        run.next_tick = {"power_margin": -3.5}
        watched.wait_for(is_text("power-margin-worst", "−3.500 W"))
        assert watched.text("#power-tolerance") == "none: the tank is required"
        assert "negative" not in str(watched.page.get_attribute("#power-margin-worst", "class"))


def test_a_link_is_changed_by_its_slider(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    slider = "input[aria-label='delay robot → filter']"
    watched.wait_for(f'document.querySelector("{slider}") && !document.querySelector("{slider}").disabled')
    watched.page.fill(slider, "50")
    watched.wait_for(is_text("panel-answer", "acknowledged: robot → filter"))
    watched.wait_for(f"document.querySelector(\"{slider}\").getAttribute('aria-valuetext') === '250 ms'")
    assert run.links.links["plant-to-filter"].settings.delay_s == 0.25
    watched.page.click("button[aria-label='Outage robot → filter']")
    watched.wait_for("document.querySelector(\"button[aria-label='Outage robot → filter']\").textContent === 'End it'")
    assert run.links.links["plant-to-filter"].settings.outages_s
    assert run.links.links["plant-to-filter"].settings.delay_s == 0.25
    watched.page.goto(f"{served.url}/#engineer")
    run.links.links["plant-to-filter"].reconfigure(LinkSettings(distribution="pareto", rate_hz=400.0, duplicate=0.02))
    served.in_loop(run.links.publish_states, time.monotonic_ns())
    watched.wait_for(
        "document.getElementById('link-states').rows[2]?.cells[4].textContent"
        " === 'pareto, copies 2 %, 400/s, queue 1000'"
    )
    assert watched.complaints == []


def test_a_preset_makes_every_link_like_a_network(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for("document.querySelector('.preset select')?.options.length > 5")
    watched.page.select_option(".preset select", "lte-driving")
    watched.wait_for(is_text("panel-answer", "acknowledged by all links"))
    assert {link.settings.network for link in run.links.links.values()} == {"lte-driving"}


def test_reason_for_an_unchanged_link_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    table = LinkSettings(distribution="histogram", quantiles_s=(0.0, 0.1))
    run.links.links["operator-to-filter"].reconfigure(table)
    watched.page.goto(served.url)
    slider = "input[aria-label='jitter you → filter']"
    watched.wait_for(f'document.querySelector("{slider}") && !document.querySelector("{slider}").disabled')
    served.in_loop(run.links.publish_states, time.monotonic_ns())
    watched.page.fill(slider, "30")
    reason = "jitter_s: got 0.018, allowed 0 if the distribution is histogram"
    watched.wait_for(f"document.getElementById('panel-answer').textContent.includes('{reason}')")
    assert run.links.requests == []


@pytest.mark.parametrize("how", ["click", "key"])
def test_the_stop_is_pressed_and_cleared_on_the_page(
    watched: Watched, served: ServedPage, run: FastRun, how: str
) -> None:
    answers = [False, True]
    watched.page.on("dialog", lambda dialog: dialog.accept() if answers.pop(0) else dialog.dismiss())
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    assert watched.page.is_hidden("#clear")

    if how == "click":
        watched.page.click("#stop")
    else:
        watched.page.keyboard.press("Escape")

    watched.wait_for(is_text("stop-answer", "Stopped: pressed at dashboard."))
    watched.wait_for(is_text("headline", "Emergency stop"))
    assert run.latch.is_latched
    watched.page.click("#clear")  # and no
    assert run.latch.is_latched
    watched.page.click("#clear")
    watched.wait_for("document.getElementById('clear').hidden")
    assert not run.latch.is_latched
    assert watched.complaints == []


@pytest.mark.parametrize("width", [390, 1024, 1366])
def test_a_latched_stop_leaves_the_bar_in_order(watched: Watched, served: ServedPage, width: int) -> None:
    watched.page.set_viewport_size({"width": width, "height": 768})
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    watched.page.click("#stop")
    watched.wait_for("!document.getElementById('clear').hidden")

    names = (*((".what",) if width > 900 else ()), "#connection", "#clear", "#stop")
    boxes = [watched.page.locator(name).bounding_box() for name in names]
    lefts = [box["x"] for box in boxes]
    rights = [box["x"] + box["width"] for box in boxes]
    assert all(right <= left for right, left in zip(rights[:-1], lefts[1:], strict=True)), boxes
    assert rights[-1] <= width
    assert max(box["y"] for box in boxes) < min(box["y"] + box["height"] for box in boxes), "not in one row"
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= width


def test_end_of_the_run_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    served.in_loop(run.broadcast.finish, "The run has ended. What is shown is its last state.")
    watched.wait_for(is_text("connection", "run ended"))
    watched.wait_for(is_text("headline", "The run is over"))
    assert watched.text("#detail") == "The run has ended. What is shown is its last state."


def test_lost_connection_is_reported_and_restored(watched: Watched, run: FastRun) -> None:
    with serve_page(run) as served:
        watched.page.goto(served.url)
        watched.wait_for(LIVE)
        port = served.port
    watched.wait_for(is_text("connection", "lost"))
    assert "the run has ended, or the dashboard does not answer" in watched.text("#banner")
    again = FastRun(Feed(paper_scenario()), speed=3.0, frame_hz=30.0)
    with serve_page(again, port=port):
        watched.wait_for(LIVE)
        watched.wait_for("document.getElementById('banner').hidden")


def test_silence_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for(LIVE)
    run.fails = True
    watched.wait_for(is_text("connection", "lost"))
    assert "has sent nothing for" in watched.text("#banner")


def test_another_scenario_is_shown_without_reloading(watched: Watched) -> None:
    run = FastRun(Feed(), speed=0.0)
    with serve_page(run) as served:
        watched.page.goto(served.url)
        assert "No scenario is known yet" in watched.text("main")
        watched.page.evaluate("globalThis.stayed = true")
        run.speed = 3.0
        watched.wait_for("document.querySelectorAll('#gaps li').length === 1")
        watched.wait_for(LIVE)
        assert watched.page.evaluate("globalThis.stayed")
        assert watched.text("h1") == "The paper's robot and disk"
    assert watched.complaints == [] or all("WebSocket" in text for text in watched.complaints)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("sheet", ["drive", "engineer"])
def test_axe_finds_no_serious_fault(watched: Watched, served: ServedPage, sheet: str, scheme: str) -> None:
    watched.page.emulate_media(color_scheme=scheme)
    watched.page.goto(f"{served.url}/#{sheet}")
    watched.wait_for(LIVE)
    watched.wait_for("parseFloat(document.getElementById('plant-time').textContent) > 1")
    assert watched.axe_faults() == []
    for tab in ("run", "processes") if sheet == "drive" else ():
        watched.page.click(f"#tab-{tab}")
        assert watched.axe_faults() == []


def test_page_is_accessible_to_screen_readers(watched: Watched, served: ServedPage) -> None:
    watched.page.goto(served.url)
    headings = watched.page.evaluate("[...document.querySelectorAll('h1, h2, h3')].map((e) => e.tagName)")
    assert headings.count("H1") == 1
    assert watched.page.evaluate("document.documentElement.lang") == "en"
    unnamed = "[...document.querySelectorAll('[role=img]')].filter((e) => !e.getAttribute('aria-label')).length"
    assert watched.page.evaluate(unnamed) == 0
    assert watched.page.evaluate("document.querySelectorAll('table:not(:has(caption))').length") == 0
    assert watched.page.evaluate("document.querySelectorAll('thead th:not([scope])').length") == 0
    assert watched.page.get_attribute("#banner", "role") == "alert"
    assert watched.page.get_attribute("#events", "role") == "log"
    assert watched.page.locator("main").count() == 1


@pytest.mark.parametrize(
    "scenario", [paper_scenario(), load_scenario("two-robots")], ids=lambda scenario: scenario.name
)
def test_the_drive_sheet_fits_one_screen(watched: Watched, scenario: Scenario) -> None:
    with serve_page(FastRun(Feed(scenario), speed=3.0, frame_hz=30.0)) as served:
        watched.page.set_viewport_size({"width": 1366, "height": 768})
        watched.page.goto(served.url)
        watched.wait_for("parseFloat(document.getElementById('plant-time').textContent) > 1")
        size = watched.page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
        assert size == [1366, 768]
        overflows = "(e) => e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1"
        cut = f"[...document.querySelectorAll('.side, .panels, .hands')].filter({overflows}).map((e) => e.className)"
        assert watched.page.evaluate(cut) == []
        watched.page.set_viewport_size({"width": 390, "height": 844})
        watched.wait_for("document.documentElement.scrollWidth <= 390")
        watched.page.click("nav [data-sheet=engineer]")
        watched.wait_for("document.documentElement.scrollWidth <= 390")
