"""A check tells of the guard, and of a truth that the sets do not contain."""

from typing import Any

import pytest
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.check.assumption import assumption_findings


def lines_of(**overrides: Any) -> list[str]:  # noqa: ANN401 - fields of a scenario
    scenario = load_scenario("notomista-cai-2020", {k.replace("__", "."): v for k, v in overrides.items()})
    return [str(finding) for finding in assumption_findings(scenario, robot_of(scenario))]


def test_an_exact_scenario_has_none() -> None:
    assert lines_of() == []


@pytest.mark.parametrize(("enabled", "words"), [(True, "judges every input"), (False, "none")])
def test_the_guard_is_reported(enabled: bool, words: str) -> None:
    [line] = lines_of(plant__guard={"enabled": enabled}, uncertainty={})

    assert words in line


@pytest.mark.parametrize(("mass", "count"), [(1.1, 0), (1.3, 1)])
def test_a_truth_outside_of_the_sets_is_a_warning(mass: float, count: int) -> None:
    lines = lines_of(uncertainty={"parameters": {"mass": [0.8, 1.2]}}, plant__truth={"parameters": {"mass": mass}})

    assert sum("outside" in line for line in lines) == count
