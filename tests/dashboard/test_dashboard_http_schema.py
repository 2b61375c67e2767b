"""Requests that schemathesis makes from the description of the HTTP interface: each gets an answer that it lists."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsed_archive import browse_folder
from closed_form import paper_scenario
from closed_form_log import circle_messages, write_log
from passafe_dashboard.live.feed import Feed
from served_page import FastRun, serve_page

UNCHECKED = "positive_data_acceptance"
"""Settings of a link may contradict one another, which a JSON schema cannot say."""


@contextmanager
def served(kind: str, folder: Path) -> Iterator[str]:
    """Serve the live page, or the pages of logs, and yield where."""
    if kind == "live":
        with serve_page(FastRun(Feed(paper_scenario())), answer_s=0.2) as page:
            yield page.url
    else:
        write_log(folder / "circle.mcap", circle_messages(300))
        with browse_folder(folder) as archive:
            yield archive.url


def ask(kind: str, folder: Path, examples: int, seed: int, *more: str) -> None:
    """Run schemathesis; its report is the message of a failure."""
    with served(kind, folder) as url:
        options = (f"--max-examples={examples}", f"--seed={seed}", f"--exclude-checks={UNCHECKED}", "--no-color")
        command = (sys.executable, "-m", "schemathesis.cli", "run", f"{url}/openapi.json", *options, *more)
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=500, check=False)
    assert run.returncode == 0, run.stdout[-6000:] + run.stderr[-2000:]


@pytest.mark.parametrize("kind", ["live", "browse"])
def test_some_requests_are_answered_as_described(kind: str, tmp_path: Path) -> None:
    ask(kind, tmp_path, 5, 1, "--phases=fuzzing,stateful")


@pytest.mark.campaign
@pytest.mark.parametrize("kind", ["live", "browse"])
@pytest.mark.parametrize("seed", range(3))
def test_many_requests_are_answered_as_described(kind: str, tmp_path: Path, seed: int) -> None:
    ask(kind, tmp_path, 300, seed)
