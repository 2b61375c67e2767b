"""An experiment is started, watched, stopped and resumed in a real browser."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from browsed_archive import browse_folder
from small_sweep import EXPERIMENT_TOML
from watched_page import Watched, open_browser

pytestmark = pytest.mark.browser


@pytest.fixture
def watched() -> Iterator[Watched]:
    with open_browser() as browser:
        opened = Watched(browser)
        yield opened
        assert opened.complaints == []


def test_a_sweep_is_driven_from_the_page(watched: Watched, tmp_path: Path) -> None:
    text = EXPERIMENT_TOML.replace("count = 2", "count = 9").replace("0.1", "2.0")
    (tmp_path / "mine.toml").write_text(text)
    page = watched.page
    with browse_folder(tmp_path) as archive:
        page.goto(f"{archive.url}/experiments")
        page.wait_for_selector("#start:not([hidden])")
        assert watched.text("#offer-size") == "4 cells, 36 runs"  # the file in the folder comes first
        page.fill("#seeds", "2000")
        assert "more than the 5000 of the page" in watched.text("#offer-size")
        page.fill("#seeds", "400")
        page.get_by_role("button", name="Start").click()
        page.wait_for_url("**/experiments/small")
        page.wait_for_selector("#map .map-cell:not([disabled])")
        page.get_by_role("button", name="Stop").click()
        page.get_by_role("button", name="Resume").wait_for()
        assert watched.text("#stage") == "interrupted"
        before = int(watched.text("#counts").split()[0])
        page.get_by_role("button", name="Resume").click()
        page.get_by_role("button", name="Stop").wait_for()
        watched.wait_for(f"parseInt(document.getElementById('counts').textContent) > {before}")
        page.goto(f"{archive.url}/experiments")
        page.wait_for_selector("#start:not([hidden])")
        page.get_by_role("button", name="Start").click()
        page.wait_for_selector("#start-answer:has-text('experiment small is running')")
    watched.complaints = [text for text in watched.complaints if "429" not in text]  # Chromium's word of it
