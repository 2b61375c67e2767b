"""Take pictures of the live page for every shipped scenario, over a running demo, shown by Chromium.

``python docs_build/page_pictures.py OUT`` writes OUT/SCENARIO-SHEET-WIDTH-SCHEME.png and says of each page whether
something overflows. It takes some two minutes; ``--scenario NAME`` takes those of one.
"""

import argparse
import re
import shutil
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

AT_S: Final = 3.0
"""Plant time from which on a picture is taken: the robot is under way."""

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
    for sheet in ("drive", "engineer"):
        page.goto(f"{address}#{sheet}")
        page.reload()
        page.wait_for_function(f"() => parseFloat(document.getElementById('plant-time')?.textContent) > {AT_S}")
        for width, height in SIZES.items():
            page.set_viewport_size({"width": width, "height": height})
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)
                before = page.evaluate("passafePage.drawn")
                page.wait_for_function(f"() => passafePage.drawn > {before + 3}")
                name = f"{stem}-{sheet}-{width}-{scheme}.png"
                page.screenshot(path=out / name, full_page=width < 900 or sheet == "engineer")  # noqa: PLR2004 - a phone
                trouble = page.evaluate(OVERFLOWS)
                sys.stdout.write(f"{name}{': ' + ', '.join(trouble) if trouble else ''}\n")
    page.close()


def main() -> None:
    """Take the pictures that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenario", choices=SCENARIOS, action="append")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        for scenario in asked.scenario or SCENARIOS:
            with demo(scenario, asked.out / "runs") as address:
                take_pictures(browser, address, scenario, asked.out)
        browser.close()


if __name__ == "__main__":
    main()
