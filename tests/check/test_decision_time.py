"""The time of decisions against the period, with a clock of the test's own."""

import re
from itertools import count

import pytest
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.check.decision_time import decision_time_finding

from passafe.filter import SafetyPassivityFilter
from passafe.finding import Severity

SCENARIO = load_scenario("notomista-cai-2020")


@pytest.fixture(scope="module")
def core() -> SafetyPassivityFilter:
    return SafetyPassivityFilter(design_of(SCENARIO, robot_of(SCENARIO)))


@pytest.mark.parametrize(("share", "severity"), [(0.5, Severity.NOTE), (2.0, Severity.WARNING)])
def test_decisions_longer_than_the_period_warn(core: SafetyPassivityFilter, share: float, severity: Severity) -> None:
    ticks = count()
    found = decision_time_finding(core, SCENARIO.plant.x0, 1, lambda: share * core.design.dt_s * next(ticks))

    assert found.severity is severity
    assert found.found.startswith(f"99% of 800 decisions take up to {1e3 * share * core.design.dt_s:.3g} ms")
    assert bool(found.advice) is (severity is Severity.WARNING)


def test_time_is_that_of_this_processor(core: SafetyPassivityFilter) -> None:
    found = decision_time_finding(core, SCENARIO.plant.x0, 1).found

    most_ms, longest_ms = (float(each) for each in re.findall(r"([0-9.e-]+) ms", found)[:2])
    assert 1e-3 < most_ms <= longest_ms < 1e4  # a decision takes some microseconds at the least
    assert found.endswith("the period has 1 ms")
