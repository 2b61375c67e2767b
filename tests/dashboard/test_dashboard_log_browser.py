"""The pages of logs and experiments in a real browser."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsed_archive import BrowsedArchive, browse_folder
from closed_form_log import circle_messages, write_log
from small_sweep import small_results, small_study, write_results
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with open_browser() as started:
        yield started


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a runs folder with two circles, a file that is no log, and a sweep."""
    folder = tmp_path_factory.mktemp("runs")
    write_log(folder / "circle 1.mcap", circle_messages(2_000))
    shutil.copy(folder / "circle 1.mcap", folder / "ö#2?.mcap")
    (folder / "words.mcap").write_text("no log")
    study = small_study()
    write_results(folder / "small", study, small_results(study))
    return folder


@pytest.fixture(scope="module")
def archive(runs: Path) -> Iterator[BrowsedArchive]:
    with browse_folder(runs) as served:
        yield served


@pytest.fixture
def watched(browser: Any) -> Iterator[Watched]:  # noqa: ANN401 - playwright's
    opened = Watched(browser)
    yield opened
    assert opened.complaints == []
    opened.page.close()


def open_page(watched: Watched, archive: BrowsedArchive, path: str) -> None:
    watched.page.goto(archive.url + path)
    watched.page.wait_for_selector("body[data-ready]")


def test_a_log_is_opened_from_the_list_and_played(watched: Watched, archive: BrowsedArchive) -> None:
    open_page(watched, archive, "/logs")
    watched.page.get_by_role("link", name="circle 1.mcap").click()
    watched.page.wait_for_selector("body[data-ready=true]")
    assert "is violated" in watched.page.locator("#report .badge").text_content()
    watched.page.go_back()
    row = watched.page.locator("tr", has_text="circle 1.mcap")
    row.locator(".verdict[data-outcome=fails]").wait_for()
    row.get_by_role("link").click()
    watched.page.wait_for_selector("body[data-ready=true]")
    assert watched.page.locator("#report canvas").count() == 13
    watched.page.get_by_role("button", name="plant in its fail-safe").click()
    watched.page.wait_for_selector("[data-part=time]:text-is('0.200 s')")
    watched.page.select_option("[data-part=speed]", "0.1")  # it does not come to its end before the pause
    watched.page.get_by_role("button", name="Play").click()
    watched.wait_for("parseFloat(document.querySelector('[data-part=time]').textContent) > 0.25")
    watched.page.get_by_role("button", name="Pause").click()
    watched.page.keyboard.press("w")  # the worst moment: nothing is violated, so that of the lowest h
    worst = watched.page.get_attribute("[data-part=worst]", "data-jump")
    watched.wait_for(f"Math.abs(parseFloat(document.querySelector('[data-part=time]').textContent) - {worst}) < 1e-3")
    for _ in range(5):
        watched.page.keyboard.press("p")
    watched.page.keyboard.press("n")
    watched.wait_for("document.querySelectorAll('[data-jump][aria-current]').length === 1")
    assert all(url.startswith((archive.url, "data:")) for url in watched.requests)


def test_two_logs_are_compared_from_the_list(watched: Watched, archive: BrowsedArchive) -> None:
    open_page(watched, archive, "/logs")
    watched.page.get_by_label("compare circle 1.mcap").check()
    watched.page.get_by_label("compare ö#2?.mcap").check()
    watched.page.get_by_role("button", name="Compare two").click()
    watched.page.wait_for_selector("body[data-ready=true]")
    assert watched.page.locator("table.compared tbody tr").count() > 5
    legend = watched.page.locator("#chart-h .key .value").first.text_content()
    assert legend == "2.24 | 2.24"


def test_trouble_is_shown_in_the_page(watched: Watched, archive: BrowsedArchive) -> None:
    open_page(watched, archive, "/logs/words.mcap")
    assert "no MCAP" in watched.text("#job-trouble")
    watched.page.goto(f"{archive.url}/logs/gone.mcap")
    watched.page.wait_for_selector("body[data-ready]")
    assert "got 'gone.mcap'" in watched.text("#job-trouble")
    watched.complaints = [text for text in watched.complaints if "404" not in text]  # Chromium's word of it


def test_a_cell_of_a_sweep_shows_its_runs(watched: Watched, archive: BrowsedArchive) -> None:
    open_page(watched, archive, "/experiments")
    watched.page.get_by_role("link", name="small").click()
    watched.page.wait_for_selector("#map [data-cell]")
    assert watched.page.locator("#map tbody tr").count() == 2
    watched.page.select_option("#criterion", "quick")
    shares = watched.page.locator("#map [data-cell]").evaluate_all("(cells) => cells.map((cell) => cell.dataset.share)")
    assert set(shares) <= {"none", "some", "all"}
    watched.page.locator("[data-cell='3']").press("Enter")
    assert watched.text("#cell-title") == "Cell 3: both, delay_s 0.02"
    assert watched.page.get_by_role("button", name="again and open it").is_enabled()


@pytest.mark.parametrize("width", [390, 1024, 1440])
@pytest.mark.parametrize("path", ["/logs", "/logs/circle%201.mcap", "/experiments", "/experiments/small"])
def test_the_pages_fit_their_window(watched: Watched, archive: BrowsedArchive, path: str, width: int) -> None:
    watched.page.set_viewport_size({"width": width, "height": 800})
    open_page(watched, archive, path)
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("path", ["/logs", "/logs/circle%201.mcap", "/experiments", "/experiments/small"])
def test_axe_finds_no_serious_fault(watched: Watched, archive: BrowsedArchive, path: str, scheme: str) -> None:
    watched.page.emulate_media(color_scheme=scheme)
    open_page(watched, archive, path)
    if path == "/experiments":
        watched.page.wait_for_selector("#start:not([hidden])")
    if path.endswith("small"):
        watched.page.locator("[data-cell='3']").press("Enter")
    assert watched.axe_faults() == []
