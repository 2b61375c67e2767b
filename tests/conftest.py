"""Settings of every test, and which files begin first."""

from typing import Final

import pytest
from hypothesis import HealthCheck, settings

# A busy machine makes no test fail: what a test may take is bounded by its number of examples.
settings.register_profile("passafe", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("passafe")

LONGEST: Final = (
    "test_compiled_wheel",
    "test_batch_filter",
    "test_experiment_cli",
    "test_live_demo_ends",
    "test_generated_campaign",
    "test_benchmarks",
    "test_constraint_feasibility",
    "test_wheel",
    "test_cli",
    "test_dashboard_browser",
    "test_check_cli",
    "test_batch_loop",
    "test_docs_commands",
    "test_shipped_scenarios",
    "test_changed_logs",
    "test_boundary_barriers",
    "test_input_sequence_loop",
    "test_campaign",
)
"""Files that take longest: begun last, one of them would run while other workers have nothing left to do."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first, where the workers of ``make test`` take one after the other."""
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of ``make wheel-test``."""
    parser.addoption(
        "--interpreter", help="Python to install the wheel for, with all that it requires from the package index."
    )
