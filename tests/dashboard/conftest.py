"""A page of the paper's scenario, a new one for each test; robots of a user's own are known to them."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from closed_form import paper_scenario
from passafe_dashboard.live.feed import Feed
from served_page import FastRun, ServedPage, serve_page

sys.path.append(str(Path(__file__).parents[1] / "robots"))


@pytest.fixture
def run() -> FastRun:
    return FastRun(Feed(paper_scenario()))


@pytest.fixture
def page(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run) as served:
        yield served
