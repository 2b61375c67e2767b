"""Take the picture of a report: a run over a bad link, its log reviewed, the page shown by Chromium.

``python docs_build/report_picture.py docs/pictures/report.png`` simulates the run first, which takes some seconds.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from playwright.sync_api import sync_playwright

COMMAND: Final = (sys.executable, "-m", "passafe_services.cli")
RUN: Final = (
    *("simulate", "--scenario", "walls-and-disks", "--duration", "10"),
    *("--link", "plant-to-filter:delay=0.25,jitter=0.05,loss=0.1"),
)
WIDTH: Final = 1280
HEIGHT: Final = 900
AT: Final = "1600"
"""Place of the slider: beside the disk, where the filter changes the input."""


def take_picture(target: Path) -> None:
    """Simulate, review and write the picture."""
    with TemporaryDirectory() as folder:
        log, page = Path(folder) / "run.mcap", Path(folder) / "report.html"
        subprocess.run([*COMMAND, *RUN, "--out", str(log)], check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - ours
        subprocess.run([*COMMAND, "review", str(log), "--html", str(page)], check=True)  # noqa: S603 - ours
        with sync_playwright() as driver:
            browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            shown = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
            shown.goto(page.as_uri())
            shown.wait_for_selector("body[data-ready]")
            move = "(slider, at) => { slider.value = at; slider.dispatchEvent(new Event('input')); }"
            shown.locator("[data-part=slider]").evaluate(move, AT)
            shown.screenshot(path=target, animations="disabled")
            browser.close()


if __name__ == "__main__":
    take_picture(Path(sys.argv[1]))
