"""Measures what a page costs its browser, and how often it draws: ``python benchmarks/page_frames.py``.

One demo at 500 Hz, and one Chromium that renders in software. By turns its tab shows nothing, the drive sheet, the
drive sheet with a hand on the stick, and the engineers' sheet. For each: frames that the page drew a second, the time
between two, and the processor time of the browser by kind of its processes. ``--against FILE``: by turns the drive
sheet with another script too, such as the ``/live.js`` of an older version.
"""

import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from math import cos, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Final

import numpy as np
import psutil
import typer
from live_page import demo
from report import AsJson, Ratio, Report, Smallest
from timing import in_turn

ARGUMENTS: Final = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
NOTE_DRAWS: Final = """
globalThis.drawnAt = [];
const draw = passafePage.draw.bind(passafePage);
passafePage.draw = (at) => { draw(at); drawnAt.push(performance.now()); };
"""
LEAST_S: Final = 0.01
"""Least processor time that a process reports, s."""

ANSWER_MS: Final = 60_000


@dataclass(kw_only=True, slots=True)
class Stretch:
    """Cost of one stretch of time.

    Attributes:
        seconds: Its length.
        drawn_ms: When the page drew, by its clock.
        processor_s: Processor time of the browser, by kind of its processes.
    """

    seconds: float
    drawn_ms: list[float] = field(default_factory=list)
    processor_s: dict[str, float] = field(default_factory=dict)

    @property
    def total_s(self) -> float:
        """Return the processor time of all processes a second."""
        return sum(self.processor_s.values()) / self.seconds


def spent_by_process() -> dict[tuple[int, str], float]:
    """Return the processor time of each process of the browser below this one, s, by its number and kind."""
    found = {}
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            words = " ".join(process.cmdline())
            if "chrom" in words.split(" ")[0]:
                named = re.search(r"--type=(\S+)", words)
                times = process.cpu_times()
                found[process.pid, named[1] if named else "browser"] = times.user + times.system
    return found


class Tab:
    """The browser's one tab.

    Args:
        page: Playwright's page.
        address: Where the dashboard serves.
        span_s: Length of a stretch.
    """

    def __init__(self, page: Any, address: str, span_s: float) -> None:  # noqa: ANN401 - playwright's
        self._page = page
        self._address = address
        self._span_s = span_s

    def blank(self) -> Stretch:
        """Return what an empty tab costs."""
        self._page.goto("about:blank")
        return self._pass(lambda: self._page.wait_for_timeout(1e3 * self._span_s))

    def watch(self, sheet: str = "drive", script: str | None = None) -> Stretch:
        """Return what a sheet costs, with the page's script or with another one."""
        self._open(sheet, script)
        return self._pass(lambda: self._page.wait_for_timeout(1e3 * self._span_s))

    def drive(self) -> Stretch:
        """Return what the drive sheet costs with a hand on the stick."""
        self._open("drive", None)
        self._page.click("#take")
        self._page.wait_for_function("() => passafePage.steering.you", timeout=ANSWER_MS)
        box = self._page.locator("#pad-0").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self._page.mouse.move(x, y)
        self._page.mouse.down()

        def circle() -> None:
            begun_s = time.monotonic()
            while (passed_s := time.monotonic() - begun_s) < self._span_s:
                self._page.mouse.move(x + 30 * cos(2 * passed_s), y + 30 * sin(2 * passed_s))
                time.sleep(1 / 60)

        made = self._pass(circle)
        self._page.mouse.up()
        self._page.click("#take")
        return made

    def _open(self, sheet: str, script: str | None) -> None:
        self._page.goto("about:blank")
        self._page.unroute_all()
        if script is not None:
            self._page.route("**/live.js", lambda route: route.fulfill(body=script, content_type="text/javascript"))
        self._page.goto(f"{self._address}/#{sheet}")
        live = "() => document.getElementById('connection').textContent === 'live'"
        self._page.wait_for_function(live, timeout=ANSWER_MS)
        self._page.evaluate(NOTE_DRAWS)
        self._page.wait_for_timeout(1000)

    def _pass(self, pass_time: Callable[[], None]) -> Stretch:
        before = spent_by_process()
        begun_s = time.monotonic()
        self._page.evaluate("() => { globalThis.drawnAt = []; }")
        pass_time()
        made = Stretch(seconds=time.monotonic() - begun_s, drawn_ms=self._page.evaluate("() => drawnAt"))
        for (process, kind), spent_s in spent_by_process().items():
            spent_before_s = before.get((process, kind), 0.0)
            made.processor_s[kind] = made.processor_s.get(kind, 0.0) + spent_s - spent_before_s
        return made


@contextmanager
def opened_tab(address: str, span_s: float) -> Iterator[Tab]:
    """Yield a tab of a browser that renders in software, as large as a laptop's screen."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - only here

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        yield Tab(browser.new_page(viewport={"width": 1366, "height": 768}), address, span_s)
        browser.close()


def row_of(name: str, stretches: list[Stretch]) -> tuple[str, ...]:
    """Return the row of a table for one kind of stretch."""
    seconds = sum(each.seconds for each in stretches)
    gaps = np.concatenate([np.diff(each.drawn_ms) for each in stretches])
    drawn = f"{sum(len(each.drawn_ms) for each in stretches) / seconds:.1f}"
    rare = f"{np.percentile(gaps, 99):.0f} ms" if gaps.size else ""
    drawn_in_all = max(sum(len(each.drawn_ms) for each in stretches), 1)
    per_frame = f"{1e3 * sum(each.total_s * each.seconds for each in stretches) / drawn_in_all:.1f} ms"
    kinds = ("renderer", "gpu-process", "browser")
    spent = [60 * sum(each.processor_s.get(kind, 0.0) for each in stretches) / seconds for kind in kinds]
    frames = (drawn, rare, per_frame) if gaps.size else ("–", "–", "–")
    return (name, *frames, *(f"{each:.1f} s" for each in spent))


def main(
    rate: Annotated[float, typer.Option(min=10.0, help="Ticks a second.")] = 500.0,
    rounds: Annotated[int, typer.Option(min=1, help="Stretches of each kind.")] = 3,
    span: Annotated[float, typer.Option(min=1.0, help="Length of a stretch, s.")] = 10.0,
    scenario: Annotated[str, typer.Option(help="Scenario that is shown.")] = "walls-and-disks",
    against: Annotated[Path | None, typer.Option(help="Another script of the page.")] = None,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report frames a second and processor time of a browser that shows the page."""
    if smallest:
        rate, rounds, span = 200.0, 1, 1.0
    names = ["empty tab", "drive sheet", "drive sheet, driving", "engineers' sheet"]
    seconds = rounds * 5 * (span + 8.0) + 60.0
    with (
        TemporaryDirectory() as folder,
        demo(Path(folder), scenario, rate, seconds) as host,
        opened_tab(f"http://{host}", span) as tab,
    ):
        measures = [tab.blank, tab.watch, tab.drive, lambda: tab.watch("engineer")]
        if against is not None:
            other = against.read_text("utf-8")
            names.append("drive sheet, other script")
            measures.append(lambda: tab.watch("drive", other))
        found = dict(zip(names, in_turn(measures, rounds), strict=True))
    columns = ("what", "frames a second", "p99 between", "a frame", "renderer, per min", "GPU process", "browser")
    report = Report(title=f"A page in Chromium, {rounds} × {span:g} s each at {rate:g} Hz", columns=columns)
    report.rows += [row_of(name, stretches) for name, stretches in found.items()]
    if against is not None:
        ours, others = ([max(each.total_s, LEAST_S) for each in found[name]] for name in ("drive sheet", names[-1]))
        report.ratios = [Ratio.of_rounds("processor time, drive sheet", ours, "with the other script", others)]
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
