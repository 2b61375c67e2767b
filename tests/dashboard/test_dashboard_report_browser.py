"""The report of a run in a real browser: one cursor, one zoom, every violation a click away."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from closed_form_log import circle_record
from closed_form_series import verdict
from passafe_dashboard.reports.report_run import ReportRun
from passafe_dashboard.reports.run_page import report_page
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser

TICK = "canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value > 0)"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with open_browser() as started:
        yield started


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the report of one run, and of two over one another."""
    folder = tmp_path_factory.mktemp("reports")
    record = circle_record(folder)
    properties = verdict()["properties"]
    properties["passive"] |= {"at_s": 1.25}
    run = ReportRun(
        label="one", record=record, verdict=verdict(properties=properties), configuration={}, versions={"passafe": "1"}
    )
    (folder / "one.html").write_text(report_page([run], title="circle"), encoding="utf-8")
    later = ReportRun(
        label="two", record=record, verdict=verdict(), configuration={}, versions={"passafe": "1"}, offset_s=0.5
    )
    (folder / "two.html").write_text(report_page([run, later], title="circles"), encoding="utf-8")
    return folder


@pytest.fixture
def watched(browser: Any) -> Iterator[Watched]:  # noqa: ANN401 - playwright's
    opened = Watched(browser)
    opened.page.context.set_offline(True)
    opened.page.set_default_timeout(10_000)
    yield opened
    assert opened.complaints == []
    assert [url for url in opened.requests if not url.startswith(("file:", "data:"))] == []
    opened.page.close()


def open_report(watched: Watched, file: Path) -> None:
    watched.page.goto(file.as_uri())
    watched.page.wait_for_selector("body[data-ready]")


def value_of(watched: Watched, chart: str, line: int = 0) -> str:
    """Value at the cursor in a chart's legend."""
    return str(watched.page.locator(f"#chart-{chart} .key .value").nth(line).text_content())


def test_every_plot_is_drawn_without_network(watched: Watched, pages: Path) -> None:
    open_report(watched, pages / "one.html")
    drawn = watched.page.evaluate(f"[...document.querySelectorAll('canvas')].map((canvas) => {TICK})")
    assert len(drawn) == 14
    assert all(drawn)
    assert value_of(watched, "status") == "PASSED"
    assert value_of(watched, "h") == "2.24"


def test_a_violation_is_a_click_away(watched: Watched, pages: Path) -> None:
    open_report(watched, pages / "one.html")
    watched.page.get_by_role("button", name="passive violated").click()
    watched.page.wait_for_selector("[data-part=time]:text-is('1.250 s')")
    assert watched.text("[data-part=stretch]") == "0.75 to 1.75 s"
    assert value_of(watched, "h") == "0.587"  # (1.5 + 0.3·cos 2.5)² − 1
    event = watched.page.get_by_role("button", name="plant in its fail-safe")
    event.click()
    watched.page.wait_for_selector("[data-part=time]:text-is('0.200 s')")
    assert value_of(watched, "status", 1) == "FAIL_SAFE"


def test_the_cursor_is_one_for_all_plots(watched: Watched, pages: Path) -> None:
    open_report(watched, pages / "one.html")
    canvas = watched.page.locator("#chart-h canvas")
    box = canvas.bounding_box()
    canvas.hover(position={"x": 62 + (box["width"] - 72) / 2, "y": 60})
    watched.page.wait_for_selector("[data-part=time]:text-matches('^(0.999|1.00)')")
    assert value_of(watched, "psi") == value_of(watched, "h") == "0.891"  # (1.5 + 0.3·cos 2)² − 1
    places = watched.page.evaluate(
        "[...document.querySelectorAll('.plot .cursor')].map((line) => Math.round(line.getBoundingClientRect().x))"
    )
    assert len(set(places)) == 1


def test_dragging_zooms_every_plot_and_back(watched: Watched, pages: Path) -> None:
    open_report(watched, pages / "one.html")
    canvas = watched.page.locator("#chart-power canvas")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    middle = box["x"] + 62 + (box["width"] - 72) / 2
    watched.page.mouse.move(middle, box["y"] + 50)
    watched.page.mouse.down()
    watched.page.mouse.move(middle + (box["width"] - 72) / 4, box["y"] + 50)
    watched.page.mouse.up()
    watched.page.wait_for_selector("[data-part=stretch]:text-matches('^(0.99|1.00).* to (1.49|1.50)')")
    watched.page.keyboard.press("0")
    watched.page.wait_for_selector("[data-part=stretch]:text-matches('^0.00 to 2.0')")
    watched.page.keyboard.press("+")
    watched.page.wait_for_selector("[data-part=stretch]:text-matches('to .*')")
    assert watched.text("[data-part=stretch]") != "0.00 to 2.00 s"


def test_two_runs_lie_over_one_another(watched: Watched, pages: Path) -> None:
    open_report(watched, pages / "two.html")
    slider = watched.page.locator("[data-part=slider]")
    slider.evaluate("(slider) => { slider.value = '4000'; slider.dispatchEvent(new Event('input')); }")
    watched.page.wait_for_selector("[data-part=time]:text-matches('^1.00')")
    one, two = value_of(watched, "h").split(" | ")
    assert one == "0.891"
    assert two == "1.76"  # what the first one was half a second before


@pytest.mark.parametrize("width", [390, 1024, 1440])
def test_the_report_fits_its_window(watched: Watched, pages: Path, width: int) -> None:
    watched.page.set_viewport_size({"width": width, "height": 800})
    open_report(watched, pages / "one.html")
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= width
    unnamed = "[...document.querySelectorAll('[role=img]')].filter((e) => !e.getAttribute('aria-label')).length"
    assert watched.page.evaluate(unnamed) == 0
    assert watched.page.evaluate("document.querySelectorAll('thead th:not([scope])').length") == 0
    assert watched.page.evaluate("document.querySelectorAll('table:not(:has(caption)):not(details table)').length") == 0
