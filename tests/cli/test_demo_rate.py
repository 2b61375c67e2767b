"""The rate of a demo where a browser needs the processors too."""

import os

import pytest
from passafe_services.cli.demo_rate import FEW_PROCESSORS, PAGE_RATE_HZ, limited_beside_page
from passafe_services.loop.realtime import available_processors
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.scenarios.schema import Scenario


def limited(scenario: Scenario, processors: int) -> tuple[Scenario, list[str]]:
    lines: list[str] = []
    return limited_beside_page(scenario, processors, lines.append), lines


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if load_scenario(name).rate_hz > PAGE_RATE_HZ])
def test_shipped_scenario_is_slowed_and_the_override_named(name: str) -> None:
    scenario = load_scenario(name)

    slower, [line] = limited(scenario, FEW_PROCESSORS)

    assert slower == load_scenario(name, {"rate_hz": PAGE_RATE_HZ})
    assert "500 ticks a second, not the scenario's 1000" in line
    assert "2 processors" in line
    assert "--rate 1000" in line


def test_more_processors_leave_the_rate_unchanged() -> None:
    scenario = load_scenario("notomista-cai-2020")

    assert limited(scenario, FEW_PROCESSORS + 1) == (scenario, [])


def test_slow_scenario_keeps_its_rate() -> None:
    scenario = load_scenario("notomista-cai-2020", {"rate_hz": PAGE_RATE_HZ})

    assert limited(scenario, 1) == (scenario, [])


def test_scenario_that_supports_no_other_rate_keeps_it() -> None:
    scenario = load_scenario("notomista-cai-2020", {"filter.k_i": PAGE_RATE_HZ + 50.0})

    assert limited(scenario, 1) == (scenario, [])


def test_processors_are_those_of_the_cpu_affinity() -> None:
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})

        assert available_processors() == 1
    finally:
        os.sched_setaffinity(0, allowed)
