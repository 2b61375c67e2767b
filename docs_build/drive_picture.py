"""Take the pictures of the drive sheet for README: a person drives into disks, and the robot is held.

``python docs_build/drive_picture.py docs/pictures`` writes drive-sheet.png and drive-sheet.gif; it takes half a minute.
Pictures are those that Chromium casts while it draws: a page that has to stand still for one stops driving.
"""

import base64
import io
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from page_pictures import demo
from PIL import Image
from playwright.sync_api import sync_playwright

SCENARIO: Final = "walls-and-disks"
SPRING: Final = 4.0
"""Stiffness of the scenario's feedback: a command of 4·p lets the robot rest at p, were it not held."""

WAY: Final = ((0.3, -0.7), (1.6, 0.5), (2.9, 1.9), (-1.0, 0.6))
"""Places that the person drives at: a disk, another, a corner, the third disk."""

WIDTH: Final = 1366
HEIGHT: Final = 768
GIF_WIDTH: Final = 900
HOLD_MS: Final = 1800
EACH_NTH: Final = 10
"""Of the frames that Chromium draws, sixty a second."""

MIDDLE: Final = (
    "(pad) => { const box = pad.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; }"
)


class Cast:
    """Frames that Chromium casts of a page."""

    def __init__(self, page: Any) -> None:  # noqa: ANN401 - playwright's
        self.frames: list[bytes] = []
        self._session = page.context.new_cdp_session(page)
        self._session.on("Page.screencastFrame", self._receive)
        self._session.send("Page.startScreencast", {"format": "jpeg", "quality": 92, "everyNthFrame": EACH_NTH})

    def _receive(self, event: dict[str, Any]) -> None:
        self.frames.append(base64.b64decode(event["data"]))
        self._session.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})


def take_pictures(folder: Path) -> None:
    """Drive and write both pictures."""
    with (
        TemporaryDirectory() as runs,
        demo(SCENARIO, Path(runs), "--rate", "250") as address,
        sync_playwright() as driver,
    ):
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        page.goto(address)
        page.wait_for_function("() => parseFloat(document.getElementById('plant-time').textContent) > 1")
        page.click("#take")
        page.wait_for_function("() => passafePage.steering.you")
        cast = Cast(page)
        full = page.evaluate("passafePage.setup.drive.full")
        reach = page.evaluate("passafePage.steering.pads[0].reach")
        middle = page.locator("#pad-0").evaluate(MIDDLE)
        page.mouse.move(*middle)
        page.mouse.down()
        for place in WAY:
            share = [SPRING * p / most for p, most in zip(place, full, strict=True)]
            page.mouse.move(middle[0] + share[0] * reach, middle[1] - share[1] * reach, steps=4)
            page.wait_for_timeout(HOLD_MS)
            if not page.evaluate("passafePage.steering.you"):
                raise SystemExit("the page lost the controls: this machine is too busy for pictures")
        page.screenshot(path=folder / "drive-sheet.png")
        browser.close()
    first, *others = [_small(frame).quantize(64) for frame in cast.frames]
    period_ms = len(WAY) * HOLD_MS // len(cast.frames)
    first.save(
        folder / "drive-sheet.gif", save_all=True, append_images=others, duration=period_ms, loop=0, optimize=True
    )


def _small(frame: bytes) -> Image.Image:
    shown = Image.open(io.BytesIO(frame)).convert("RGB")
    return shown.resize((GIF_WIDTH, round(shown.height * GIF_WIDTH / shown.width)), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    take_pictures(Path(sys.argv[1]))
