"""Limits the rate of a demo where a browser needs the processors too (decision 0014)."""

from collections.abc import Callable
from typing import Final

from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import scenario_from
from passafe_services.scenarios.schema import Scenario

PAGE_RATE_HZ: Final = 500.0
"""Highest rate beside a page: six processes at 1 kHz leave a browser on two processors no time to draw."""

FEW_PROCESSORS: Final = 2
"""Number of processors up to which the rate is limited."""


def limited_beside_page(scenario: Scenario, processors: int, report: Callable[[str], object]) -> Scenario:
    """Return the scenario, at ``PAGE_RATE_HZ`` where its own rate would leave a browser no time.

    Args:
        scenario: The scenario with the command line's values.
        processors: Number of processors available.
        report: Called with a line for the user if the rate is changed.
    """
    if processors > FEW_PROCESSORS or scenario.rate_hz <= PAGE_RATE_HZ:
        return scenario
    try:
        slower = scenario_from(scenario.model_dump(mode="json"), scenario.name, {"rate_hz": PAGE_RATE_HZ})
    except ScenarioError:  # the scenario supports only its own rate
        return scenario
    report(
        f"{PAGE_RATE_HZ:g} ticks a second, not the scenario's {scenario.rate_hz:g}: a browser has to draw the page "
        f"on the same {processors} processors; --rate {scenario.rate_hz:g} insists, --headless does without a page"
    )
    return slower
