"""How many ticks a second a demo has where a browser needs the processors too."""

import os

import pytest
from passafe_services.cli.demo import FEW_PROCESSORS, PAGE_RATE_HZ, with_room_for_a_page
from passafe_services.loop.realtime import processors
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.scenarios.schema import Scenario


def roomy(scenario: Scenario, count: int) -> tuple[Scenario, list[str]]:
    said: list[str] = []
    return with_room_for_a_page(scenario, count, said.append), said


@pytest.mark.parametrize("name", shipped_scenarios())
def test_a_shipped_scenario_gets_slower_on_two_processors_and_says_what_insists(name: str) -> None:
    scenario = load_scenario(name)

    slower, [said] = roomy(scenario, FEW_PROCESSORS)

    assert slower == load_scenario(name, {"rate_hz": PAGE_RATE_HZ})
    assert "500 ticks a second, not the scenario's 1000" in said
    assert "2 processors" in said
    assert "--rate 1000" in said


def test_with_more_processors_a_scenario_stays_as_it_is() -> None:
    scenario = load_scenario("notomista-cai-2020")

    assert roomy(scenario, FEW_PROCESSORS + 1) == (scenario, [])


def test_a_scenario_that_is_slow_already_stays_as_it_is() -> None:
    scenario = load_scenario("notomista-cai-2020", {"rate_hz": PAGE_RATE_HZ})

    assert roomy(scenario, 1) == (scenario, [])


def test_a_scenario_that_stands_no_other_rate_stays_as_it_is() -> None:
    scenario = load_scenario("notomista-cai-2020", {"filter.k_i": PAGE_RATE_HZ + 50.0})

    assert roomy(scenario, 1) == (scenario, [])


def test_processors_are_those_that_this_process_may_use() -> None:
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})

        assert processors() == 1
    finally:
        os.sched_setaffinity(0, allowed)
