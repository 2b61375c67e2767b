"""Sets, guard and truth in scenario files: numbers per state, ranges, and what is refused by name."""

from typing import Any

import pytest
from passafe_services.scenarios.design import guard_design_of, robot_of
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.uncertain_robot import guard_uncertainty_of, true_system_of, uncertainty_of

SETS: dict[str, Any] = {
    "parameters": {"mass": [0.8, 1.2]},
    "disturbance": {"velocity": 0.5},
    "state_error": [0.001, 0.002, 0.01, 0.02],
}


def scenario_of(name: str = "notomista-cai-2020", **overrides: object) -> Scenario:
    return load_scenario(name, {key.replace("__", "."): value for key, value in overrides.items()})


def test_a_scenario_without_the_sections_is_exact() -> None:
    scenario = scenario_of()

    assert scenario.is_exact
    assert not scenario.has_guard
    assert uncertainty_of(scenario, robot_of(scenario)) is None
    assert true_system_of(scenario, robot_of(scenario)) is not None


@pytest.mark.parametrize("key", ["uncertainty", "plant__truth", "plant__guard"])
def test_each_section_makes_it_inexact(key: str) -> None:
    assert not scenario_of(**{key: {}}).is_exact


def test_a_guard_that_is_not_enabled_is_none() -> None:
    scenario = scenario_of(plant__guard={"enabled": False})

    assert scenario.is_exact
    assert not scenario.has_guard


def test_sets_are_numbers_for_each_state() -> None:
    scenario = scenario_of(uncertainty=SETS)
    sets = uncertainty_of(scenario, robot_of(scenario))

    assert sets is not None
    assert sets.parameters == {"mass": (0.8, 1.2)}
    assert sets.disturbance == (0.0, 0.0, 0.5, 0.5)
    assert sets.state_error == (0.001, 0.002, 0.01, 0.02)


def test_other_states_have_a_number_of_their_own() -> None:
    scenario = scenario_of("lagged-point", uncertainty={"disturbance": {"position": 1.0, "other": 3.0}})
    sets = uncertainty_of(scenario, robot_of(scenario))

    assert sets is not None
    assert sets.disturbance == (1.0, 1.0, 0.0, 0.0, 3.0, 3.0)


def test_the_guard_reads_with_an_error_of_its_own() -> None:
    scenario = scenario_of(uncertainty=SETS, plant__guard={"state_error": {"velocity": 0.001}})
    sets = guard_uncertainty_of(scenario, robot_of(scenario))

    assert sets is not None
    assert sets.disturbance == (0.0, 0.0, 0.5, 0.5)
    assert sets.state_error == (0.0, 0.0, 0.001, 0.001)


def test_the_guard_has_the_safety_rows_alone() -> None:
    scenario = scenario_of(plant__guard={}, filter__gatekeeper=True)
    design = guard_design_of(scenario, robot_of(scenario))

    assert design.mode.value == "safe"
    assert not design.gatekeeper
    assert design.u_fb.is_zero()


@pytest.mark.parametrize(
    ("section", "given", "field"),
    [
        ("uncertainty", {"parameters": {"mass": [1.2, 0.8]}}, "uncertainty.parameters.mass"),
        ("uncertainty", {"parameters": {"mass": [1.0]}}, "uncertainty.parameters.mass"),
        ("uncertainty", {"disturbance": {"velocity": -0.5}}, "uncertainty.disturbance.velocity"),
        ("uncertainty", {"disturbance": {"speed": 0.5}}, "uncertainty.disturbance.speed"),
        ("uncertainty", {"actuator_lag_s": 2.0}, "uncertainty.actuator_lag_s"),
        ("plant__truth", {"disturbance": {"kind": "windy"}}, "plant.truth.disturbance.kind"),
        ("plant__truth", {"noise": {"bound": [-1.0]}}, "plant.truth.noise.bound.0"),
        ("plant__guard", {"enabled": "perhaps"}, "plant.guard.enabled"),
    ],
)
def test_files_are_refused_by_the_field(section: str, given: dict[str, Any], field: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        scenario_of(**{section: given})

    assert caught.value.field == field


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"parameters": {"mas": [0.8, 1.2]}}, "uncertainty.parameters"),
        ({"parameters": {"mass": [1.1, 1.2]}}, "uncertainty.parameters.mass"),
        ({"state_error": [0.1]}, "uncertainty.state_error"),
    ],
)
def test_what_does_not_fit_the_robot_is_refused(given: dict[str, Any], field: str) -> None:
    scenario = scenario_of(uncertainty=given)

    with pytest.raises(ScenarioError) as caught:
        uncertainty_of(scenario, robot_of(scenario))

    assert caught.value.field == field
