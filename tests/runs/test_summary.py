from math import inf, nan

import pytest
from passafe_services.tools.runs.summary import Spread, badness


def test_the_spread_of_values_leaves_missing_ones_out() -> None:
    assert Spread.of([3.0, None, 1.0, 2.5]) == Spread(min=1.0, median=2.5, max=3.0)
    assert Spread.of([None, None]) is None


def test_the_spread_of_infinite_values_has_a_median() -> None:
    assert Spread.of([1.0, inf]) == Spread(min=1.0, median=1.0, max=inf)


@pytest.mark.parametrize(("high_is_worse", "worst"), [(False, 1), (True, 2)])
def test_the_worst_is_the_first_of_equal_ones(high_is_worse: bool, worst: int) -> None:
    values = [2.0, 1.0, 3.0, 1.0, 3.0]

    found = max(range(5), key=lambda k: badness(values[k], high_is_worse=high_is_worse))

    assert found == worst


@pytest.mark.parametrize("missing", [None, nan])
@pytest.mark.parametrize("high_is_worse", [False, True])
def test_nothing_is_worse_than_no_value(missing: float | None, high_is_worse: bool) -> None:
    values = [-1e300, missing, 1e300]

    assert max(values, key=lambda value: badness(value, high_is_worse=high_is_worse)) is missing
