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
from passafe_services.scenarios.schema import Scenario
from served_page import FastRun, ServedPage, serve_page
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser


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


def rows_of(name: str, column: str) -> str:
    """JavaScript for a column of a chart's table, numbers only."""
    found = f"Array.from(Bokeh.documents[0].get_model_by_name('{name}').data['{column}'])"
    return f"{found}.filter(Number.isFinite)"


def middle_of(name: str, column: str) -> str:
    """JavaScript for the middle of what a column of a chart's table spans."""
    rows = rows_of(name, column)
    return f"((Math.min(...{rows}) + Math.max(...{rows})) / 2)"


def test_the_live_page_shows_the_run(watched: Watched, served: ServedPage, tmp_path: Path) -> None:
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('connection').textContent === 'live'")
    watched.wait_for("parseFloat(document.getElementById('plant-time').textContent) > 7")
    watched.wait_for(f"globalThis.Bokeh && Bokeh.documents.length && {rows_of('ticks', 'psi_0_0')}.length > 100")
    assert watched.page.is_hidden("#banner")
    assert watched.text("#status") in ("PASSED", "MODIFIED")
    assert watched.text("#mode") == "both"
    cells = watched.page.locator("#barriers tr").first.locator("th, td").all_text_contents()
    assert cells[0] == "disk"
    assert cells[2] == "0.4400"
    assert float(watched.text("#power-margin").split()[0]) > 0
    assert watched.page.locator("#rows tr").first.locator("td").first.text_content() == "active"
    assert watched.text("#state-age") == "1.2 ms"
    assert watched.text("#held-back").split()[0] == "5.0000"
    assert watched.text("#allowed") == "62 %"
    assert watched.text("#infeasibility") == "12.5000"
    assert "plant" in watched.page.locator("#processes th").all_text_contents()
    drawn = watched.page.evaluate(rows_of("states", "h_0"))
    assert min(drawn) >= 0.44 - 1e-6
    assert max(drawn) <= h(0.0) + 1e-6
    assert len(watched.page.evaluate(rows_of("robot", "p1_m"))) == 1
    watched.page.screenshot(path=tmp_path / "live.png", full_page=True)
    assert watched.complaints == []
    assert all(url.startswith((served.url, "data:", f"ws://{served.host}")) for url in watched.requests)


def test_dip_of_one_tick_is_shown_on_the_page(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for(f"globalThis.Bokeh && Bokeh.documents.length && {rows_of('ticks', 'psi_0_0')}.length > 5")

    run.next_tick = {"power_margin": -0.01}
    watched.wait_for("document.getElementById('power-margin-worst').textContent === '−0.0100 W'")
    assert "negative" not in str(watched.page.get_attribute("#power-margin-worst", "class"))
    run.next_tick = {
        "power_margin": -3.5,
        "barriers": (BarrierReport("disk", (-0.25, -1.0, -2.0)),),
        "status": FilterStatus.INFEASIBLE,
    }
    watched.wait_for("document.getElementById('power-margin-worst').textContent === '−3.5000 W'")
    watched.wait_for("document.getElementById('power-margin-worst').classList.contains('negative')")
    watched.wait_for(f"Math.min(...{rows_of('ticks', 'psi_0_0')}) === -0.25")
    watched.wait_for(f"Math.max(...{rows_of('ticks', 'status')}) === {FilterStatus.INFEASIBLE.severity}")
    watched.wait_for("document.querySelector('[data-count=INFEASIBLE]').textContent === '1'")
    assert watched.complaints == []


def test_moving_region_is_drawn_at_its_current_place(watched: Watched) -> None:
    values = paper_scenario().model_dump()
    motion = {"kind": "swing", "amplitude_m": (0.5, -0.25), "frequency_hz": 0.2}
    disk = values["filter"]["barriers"][0]
    values["filter"]["barriers"] = [disk | {"centre": (3.0, 1.0), "motion": motion}]
    run = FastRun(Feed(Scenario.model_validate(values)), speed=3.0, frame_hz=30.0)
    with serve_page(run) as served:
        watched.page.goto(served.url)
        watched.wait_for("globalThis.Bokeh && Bokeh.documents.length && Bokeh.documents[0].get_model_by_name('robot')")
        p1, p2 = middle_of("moving_0", "p1_m"), middle_of("moving_0", "p2_m")
        watched.wait_for(f"{p1} > 3.4")
        watched.wait_for(f"{p1} < 2.6")
        place = watched.page.evaluate(f"[{p1}, {p2}]")
        assert place[1] - 1.0 == pytest.approx(-(place[0] - 3.0) / 2)
    assert watched.complaints == [] or all("WebSocket" in text for text in watched.complaints)


def test_a_link_is_changed_from_the_page(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('link-states').rows.length === 4")
    watched.page.select_option("#link-name", "plant-to-filter")
    watched.wait_for("document.getElementById('link-delay').value === '0'")
    for field, value in (("delay", "200"), ("jitter", "20"), ("loss", "12.5")):
        watched.page.fill(f"#link-{field}", value)
    watched.page.click("#link-form button")
    watched.wait_for(
        "document.getElementById('link-answer').textContent"
        " === 'plant-to-filter: now 200 ms, jitter 20 ms, loss 12.5 %'"
    )
    watched.wait_for("document.getElementById('link-states').rows[2].cells[1].textContent === '200'")
    settings = run.links.links["plant-to-filter"].settings
    assert (settings.delay_s, settings.jitter_s, settings.loss) == (0.2, 0.02, 0.125)
    run.links.links["plant-to-filter"].reconfigure(LinkSettings(distribution="pareto", rate_hz=400.0, duplicate=0.02))
    served.in_loop(run.links.publish_states, time.monotonic_ns())
    watched.wait_for(
        "document.getElementById('link-states').rows[2].cells[4].textContent"
        " === 'pareto, copies 2 %, 400/s, queue 1000'"
    )
    assert watched.complaints == []


def test_reason_for_an_unchanged_link_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    table = LinkSettings(distribution="histogram", quantiles_s=(0.0, 0.1))
    run.links.links["operator-to-filter"].reconfigure(table)
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('link-delay').value === '0'")
    served.in_loop(run.links.publish_states, time.monotonic_ns())
    watched.page.fill("#link-jitter", "20")
    watched.page.click("#link-form button")
    reason = "jitter_s: got 0.02, allowed 0 if the distribution is histogram"
    watched.wait_for(f"document.getElementById('link-answer').textContent.includes('{reason}')")
    assert run.links.requests == []


def test_the_stop_is_pressed_and_cleared_on_the_page(watched: Watched, served: ServedPage, run: FastRun) -> None:
    answers = [False, True]
    watched.page.on("dialog", lambda dialog: dialog.accept() if answers.pop(0) else dialog.dismiss())
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('connection').textContent === 'live'")
    assert watched.page.is_hidden("#clear")

    watched.page.click("#stop")

    watched.wait_for("document.getElementById('stop-answer').textContent.startsWith('Stopped: pressed at dashboard')")
    assert run.latch.is_latched
    watched.page.click("#clear")  # and no
    assert run.latch.is_latched
    watched.page.click("#clear")
    watched.wait_for("document.getElementById('clear').hidden")
    assert not run.latch.is_latched
    assert watched.complaints == []


def test_end_of_the_run_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('connection').textContent === 'live'")
    served.in_loop(run.broadcast.finish, "The run has ended. What is shown is its last state.")
    watched.wait_for("document.getElementById('connection').textContent === 'run ended'")
    assert watched.text("#banner") == "The run has ended. What is shown is its last state."
    assert watched.page.is_visible("#banner")


def test_lost_connection_is_reported_and_restored(watched: Watched, run: FastRun) -> None:
    with serve_page(run) as served:
        watched.page.goto(served.url)
        watched.wait_for("document.getElementById('connection').textContent === 'live'")
        port = served.port
    watched.wait_for("document.getElementById('connection').textContent === 'lost'")
    assert "the run has ended, or the dashboard does not answer" in watched.text("#banner")
    again = FastRun(Feed(paper_scenario()), speed=3.0, frame_hz=30.0)
    with serve_page(again, port=port):
        watched.wait_for("document.getElementById('connection').textContent === 'live'")
        watched.wait_for("document.getElementById('banner').hidden")


def test_silence_is_shown(watched: Watched, served: ServedPage, run: FastRun) -> None:
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('connection').textContent === 'live'")
    run.fails = True
    watched.wait_for("document.getElementById('connection').textContent === 'lost'")
    assert "has sent nothing for" in watched.text("#banner")


def test_page_of_another_scenario_reloads(watched: Watched) -> None:
    run = FastRun(Feed(), speed=0.0)
    with serve_page(run) as served:
        watched.page.goto(served.url)
        assert "No scenario is known yet" in watched.text("header")
        run.speed = 3.0
        watched.wait_for("document.querySelectorAll('.chart').length === 7")
        watched.wait_for("document.getElementById('connection').textContent === 'live'")
    assert watched.complaints == [] or all("WebSocket" in text for text in watched.complaints)


def test_page_is_accessible_to_screen_readers(watched: Watched, served: ServedPage) -> None:
    watched.page.goto(served.url)
    headings = watched.page.evaluate("[...document.querySelectorAll('h1, h2, h3')].map((e) => e.tagName)")
    assert headings[0] == "H1"
    assert headings.count("H1") == 1
    assert "H3" not in headings
    assert watched.page.evaluate("document.documentElement.lang") == "en"
    unnamed = "[...document.querySelectorAll('[role=img]')].filter((e) => !e.getAttribute('aria-label')).length"
    assert watched.page.evaluate(unnamed) == 0
    assert watched.page.evaluate("document.querySelectorAll('[role=img]').length") == 7
    assert watched.page.evaluate("document.querySelectorAll('table:not(:has(caption))').length") == 0
    assert watched.page.evaluate("document.querySelectorAll('thead th:not([scope])').length") == 0
    assert watched.page.get_attribute("#banner", "role") == "alert"
    assert watched.page.get_attribute("#events", "role") == "log"
    assert watched.page.locator("main").count() == 1


def test_the_page_fits_a_narrow_window(watched: Watched, served: ServedPage) -> None:
    watched.page.set_viewport_size({"width": 400, "height": 800})
    watched.page.goto(served.url)
    watched.wait_for("document.getElementById('connection').textContent === 'live'")
    watched.wait_for("document.documentElement.scrollWidth <= 400")
