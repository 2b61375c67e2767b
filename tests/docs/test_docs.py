"""What the documentation shows works."""

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from services.assembly import lockstep_loop
from services.scenarios.load import scenario_from

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def commands() -> list[str]:
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        found += re.findall(r"^    \.venv/bin/(passafe .*)$", text, flags=re.MULTILINE)
        found += re.findall(r"`(passafe [a-z]+ [^`]*)`", text)
    return sorted({re.sub(r"\s+", " ", command) for command in found if "…" not in command})


def test_the_readmes_python_runs_as_it_stands() -> None:
    [program] = blocks(ROOT / "README.md", "python")

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("MODIFIED")


def test_the_example_scenario_runs_as_it_stands() -> None:
    [text] = blocks(ROOT / "docs" / "scenarios.md", "toml")
    scenario = scenario_from(tomllib.loads(text), "docs/scenarios.md")

    loop = lockstep_loop(scenario)
    loop.run(300)

    assert [barrier.name for barrier in scenario.filter.barriers] == ["post", "floor"]


@pytest.mark.parametrize("command", commands())
def test_every_command_that_is_shown_has_the_options_that_are_shown(command: str) -> None:
    words = shlex.split(command)[1:]

    done = subprocess.run(
        [sys.executable, "-m", "services.cli", *words, "--help"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )

    assert done.returncode == 0, done.stderr


def test_links_between_pages_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
