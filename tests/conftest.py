"""Settings of every test."""

import pytest
from hypothesis import HealthCheck, settings

# A busy machine makes no test fail: what a test may take is bounded by its number of examples.
settings.register_profile("passafe", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("passafe")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of ``make wheel-test``."""
    parser.addoption(
        "--interpreter", help="Python to install the wheel for, with all that it requires from the package index."
    )
