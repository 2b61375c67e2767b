"""Take pictures of the live page for every shipped scenario, over a running demo, shown by Chromium.

``python docs_build/page_pictures.py OUT`` writes OUT/SCENARIO-SHEET-WIDTH-SCHEME.png, and beside the last scenario
OUT/archive-PAGE-WIDTH-SCHEME.png of the pages of logs and experiments; it says of each whether something overflows.
It takes some minutes; ``--scenario NAME`` takes those of one, ``--archive`` those of the archive besides.
"""

import argparse
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import passafe_services.scenarios
from playwright.sync_api import sync_playwright

SIZES: Final = {1440: 900, 1366: 768, 1024: 768, 390: 844}
"""Height of the window by its width, pixels."""

PORTS: Final = ("--port", "8299", "--router-port", "7499")
SCENARIOS: Final = sorted(path.stem for path in Path(passafe_services.scenarios.__file__).parent.glob("*.toml"))

RUN_S: Final = "900"
"""Longest that a run takes: on a busy machine the pictures of a scenario take longer than the scenario."""

PATIENCE_MS: Final = 120_000

SWEEP: Final = {"kind": "sweep", "source": "shipped", "experiment": "gain", "seeds": 1}

AT_S: Final = 3.0
"""Plant time from which on a picture is taken: the robot is under way."""

DRAWN_AGAIN: Final = """async () => {
  const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const before = window.passafePage?.drawn;
  await next();
  while (window.passafePage && passafePage.drawn < before + 4) await next();
  await next();
}"""

OVERFLOWS: Final = """() => {
  const root = document.documentElement;
  const wide = root.scrollWidth > innerWidth ? [`page ${root.scrollWidth} px wide`] : [];
  const cut = [...document.querySelectorAll('.side, .panels, .hands, .bar, .card')]
    .filter((e) => e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1)
    .map((e) => e.className);
  return [...wide, ...cut];
}"""


@contextmanager
def demo(scenario: str, out: Path, *options: str) -> Iterator[str]:
    """Run a demo and yield the address of its page."""
    command = [
        sys.executable,
        "-m",
        "passafe_services.cli",
        "demo",
        "--scenario",
        scenario,
        "--out",
        str(out),
        "--duration",
        RUN_S,
        *PORTS,
        *options,
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603 - ours
    assert process.stdout is not None  # noqa: S101 - it was asked for
    try:
        for line in process.stdout:
            found = re.search(r"^dashboard (http\S+)", line)
            if found:
                yield found[1]
                return
        raise SystemExit(f"the demo of {scenario} ended before it had a page")
    finally:
        process.terminate()
        process.wait(60)


def take_pictures(browser: Any, address: str, stem: str, out: Path) -> None:  # noqa: ANN401 - playwright's
    """Take the pictures of both sheets at every size, light and dark."""
    page = browser.new_page()
    page.set_default_timeout(PATIENCE_MS)
    for sheet in ("drive", "engineer"):
        page.goto(f"{address}#{sheet}")
        page.reload()
        page.wait_for_function(f"() => parseFloat(document.getElementById('plant-time')?.textContent) > {AT_S}")
        _take(page, f"{stem}-{sheet}", out, is_whole=sheet == "engineer")
    page.close()


def take_archive(browser: Any, address: str, out: Path) -> None:  # noqa: ANN401 - playwright's
    """Take the pictures of the lists, of a log and of an experiment, beside the robot."""
    page = browser.new_page()
    page.set_default_timeout(PATIENCE_MS)
    job = page.request.post(f"{address}api/jobs", data=SWEEP, timeout=PATIENCE_MS).json()
    while job["state"] in ("waiting", "running"):
        job = page.request.get(f"{address}api/jobs/{job['job']}?seen={job['changes']}", timeout=PATIENCE_MS).json()
    page.goto(f"{address}experiments/{job['experiment']}")
    page.wait_for_selector("#map [data-cell]")
    page.locator("#map [data-cell]").first.click()
    _take(page, "archive-map", out, is_whole=True)
    page.click(".open-run")
    page.wait_for_selector("body[data-ready=true] #report canvas")
    _take(page, "archive-log", out, is_whole=True)
    for name in ("logs", "experiments"):
        page.goto(f"{address}{name}")
        page.wait_for_selector("tbody tr")
        _take(page, f"archive-{name}", out)
    page.close()


def _take(page: Any, stem: str, out: Path, *, is_whole: bool = False) -> None:  # noqa: ANN401 - playwright's
    """Take the pictures of a page at every size, light and dark, each when the page has drawn itself again."""
    for width, height in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.evaluate(DRAWN_AGAIN)
            name = f"{stem}-{width}-{scheme}.png"
            page.screenshot(path=out / name, full_page=width < 900 or is_whole)  # noqa: PLR2004 - a phone
            trouble = page.evaluate(OVERFLOWS)
            sys.stdout.write(f"{name}{': ' + ', '.join(trouble) if trouble else ''}\n")
            sys.stdout.flush()


def main() -> None:
    """Take the pictures that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenario", choices=SCENARIOS, action="append")
    parser.add_argument("--archive", action="store_true")
    parser.add_argument(
        "--rate", default="", help="ticks a second, on a busy machine: fewer than the scenario asks for"
    )
    asked = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # else the demo would stay
    asked.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        chosen = asked.scenario or SCENARIOS
        for scenario in chosen:
            with demo(scenario, asked.out / "runs", *(("--rate", asked.rate) if asked.rate else ())) as address:
                take_pictures(browser, address, scenario, asked.out)
                if scenario == chosen[-1] and (asked.archive or not asked.scenario):
                    take_archive(browser, address, asked.out)
        browser.close()


if __name__ == "__main__":
    main()
