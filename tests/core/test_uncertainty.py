"""Sets of what a robot may do otherwise than its model: what is a set, and whose."""

from collections.abc import Mapping

import numpy as np
import pytest
from core_designs import paper_design

from passafe.design import FilterDesign
from passafe.errors import PassafeError
from passafe.uncertainty import Uncertainty


def test_numbers_in_every_form_are_taken() -> None:
    given = Uncertainty(parameters={"mass": np.array([0.8, 1.2])}, disturbance=(0, 0, 1, 1), state_error=[0.001] * 4)

    assert given.parameters == {"mass": (0.8, 1.2)}
    assert given.disturbance == (0.0, 0.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"parameters": 3}, "uncertainty parameters"),
        ({"parameters": {"mass": 1.0}}, "'mass'"),
        ({"parameters": {"mass": (1.2, 0.8)}}, "low ≤ high"),
        ({"parameters": {"mass": (0.8, float("inf"))}}, "two finite numbers"),
        ({"disturbance": [-1.0] * 4}, "disturbance"),
        ({"state_error": [float("nan")]}, "state_error"),
        ({"input_error": "no"}, "input_error"),
        ({"actuator_lag_s": -0.1}, "actuator_lag_s"),
    ],
)
def test_what_is_no_set_is_refused(given: Mapping[str, object], named: str) -> None:
    with pytest.raises(PassafeError, match=named):
        Uncertainty(**given)  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"parameters": {"weight": (0.8, 1.2)}}, "'weight'.*'mass'"),
        ({"parameters": {"mass": (1.1, 1.2)}}, "contains 1"),
        ({"disturbance": [0.1] * 3}, "4 numbers, or none"),
        ({"state_error": [0.1]}, "4 numbers, or none"),
        ({"input_error": [0.1] * 3}, "2 numbers, or none"),
        ({"actuator_lag_s": 0.1}, "input_rate_bound_per_s"),
    ],
)
def test_sets_of_another_system_are_refused(given: Mapping[str, object], named: str) -> None:
    with pytest.raises(PassafeError, match=named):
        paper_design(uncertainty=Uncertainty(**given))  # type: ignore[arg-type]  # wrong on purpose


def test_something_else_than_a_set_is_refused() -> None:
    with pytest.raises(PassafeError, match="an Uncertainty, or None"):
        paper_design(uncertainty={"mass": (0.8, 1.2)})


@pytest.mark.parametrize("part", [{"law": "continuous"}, {"between_samples": False}, {"gatekeeper": True}])
def test_parts_that_are_the_models_alone_are_refused(part: Mapping[str, object]) -> None:
    with pytest.raises(PassafeError, match="law sampled with between_samples, without gatekeeper"):
        paper_design(uncertainty=Uncertainty(), **part)


def test_a_lag_needs_limits_of_both_rates() -> None:
    lagging = Uncertainty(actuator_lag_s=0.1)
    with pytest.raises(PassafeError, match="input_rate_bound_per_s"):
        paper_design(uncertainty=lagging, input_rate_high_per_s=10.0)
    assert isinstance(paper_design(uncertainty=lagging, input_rate_bound_per_s=10.0), FilterDesign)
