"""A page of the paper's scenario, a new one for each test."""

from collections.abc import Iterator

import pytest
from closed_form import paper_scenario
from passafe_dashboard.live.feed import Feed
from served_page import FastRun, ServedPage, serve_page


@pytest.fixture
def run() -> FastRun:
    return FastRun(Feed(paper_scenario()))


@pytest.fixture
def page(run: FastRun) -> Iterator[ServedPage]:
    with serve_page(run) as served:
        yield served
