"""The commands that pages show have these options, and the short ones run as they stand."""

import re
import shlex
from pathlib import Path

import pytest
from pages import GENERATED, PAGES, ROOT, commands_named, lines_to_run, name_of, text_of
from passafe_services.cli.app import app
from passafe_services.tools.experiment.load import load_study
from typer.testing import CliRunner

SMALL = {
    "simulate": ["--duration", "1.0"],
    "campaign": ["--rollouts", "2", "--duration", "0.05", "--workers", "1"],
    "feasibility": ["--cells", "3", "--samples", "5"],
    "review": [],
    "export": [],
    "replay": [],
    "whatif": [],
    "compare": [],
}
"""Commands that tests run, and what makes them short; the last value of an option counts."""

LONG = {"browse", "demo", "run", "experiment", "kill", "stop", "clear"}
"""Commands that start or need processes, or take minutes: here their options are checked, in other tests their work."""


@pytest.mark.parametrize("command", sorted({command for page in PAGES for command in commands_named(page)}))
def test_command_has_the_options_shown(command: str) -> None:
    words = shlex.split(command)[1:]

    result = CliRunner().invoke(app, [*words, "--help"])

    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("page", [page for page in PAGES if lines_to_run(page)], ids=name_of)
def test_commands_of_a_page_run_in_order(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for line in lines_to_run(page):
        words = shlex.split(line)[1:]
        if words[0] in LONG:
            continue
        _simulate_what_is_read(words)
        result = CliRunner().invoke(app, [*words, *SMALL[words[0]]])

        off = "off" in words  # a run without the filter may break its properties
        assert result.exit_code in ({0, 1} if off else {0}), f"{line}\n{result.output}{result.exception}"


def test_experiments_shown_are_shipped() -> None:
    names = {shlex.split(line)[2] for page in PAGES for line in lines_to_run(page) if " experiment " in line}

    assert names
    for name in names:
        assert load_study(name).experiment.name == name


def test_make_targets_shown_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    for page in PAGES:
        shown = re.findall(r"(?:`|^    )make ([a-z-]+)", text_of(page), flags=re.MULTILINE)
        assert set(shown) <= targets, name_of(page)


def test_every_command_is_in_the_reference() -> None:
    [page] = [page for page in GENERATED if page.name == "cli.md"]
    for command in CliRunner().invoke(app, ["--help"]).output.splitlines():
        found = re.match(r"│ (\w+) {2,}", command)
        if found is not None:
            assert f"## passafe {found[1]}" in text_of(page)


def _simulate_what_is_read(words: list[str]) -> None:
    """Make the log that a command reads, where the page's own command for it is a long one."""
    if words[0] in {"review", "replay", "export", "whatif", "compare"} and not Path(words[1]).exists():
        result = CliRunner().invoke(app, ["simulate", *SMALL["simulate"], "--out", words[1]])
        assert result.exit_code == 0, result.output
