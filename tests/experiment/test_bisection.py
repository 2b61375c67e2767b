"""Bisecting an axis, on answers that are known."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.tools.experiment.axes import BisectAxis
from passafe_services.tools.experiment.bisection import Boundary, first_values, most_values, next_value


def axis(low: float = 0.0, high: float = 1.0, tolerance: float = 0.01, scan: int = 3) -> BisectAxis:
    return BisectAxis(name="d", key="a", kind="bisect", low=low, high=high, tolerance=tolerance, scan=scan)


def search(axis: BisectAxis, holds: Callable[[float], bool]) -> Boundary:
    known = {value: holds(value) for value in first_values(axis)}
    while (value := next_value(axis, known)) is not None:
        known[value] = holds(value)
    assert len(known) <= most_values(axis, 1)
    return Boundary.of(known)


@given(threshold=st.floats(0.01, 0.99), scan=st.integers(0, 9), tolerance=st.floats(1e-4, 0.2))
def test_a_single_boundary_is_found_to_the_tolerance(threshold: float, scan: int, tolerance: float) -> None:
    found = search(axis(tolerance=tolerance, scan=scan), lambda value: value < threshold)

    assert found.holds_up_to is not None
    assert found.fails_from is not None
    assert found.holds_up_to < threshold <= found.fails_from
    assert found.fails_from - found.holds_up_to <= tolerance
    assert found.monotone


def test_criteria_that_never_fail_or_never_hold_are_reported() -> None:
    everywhere, nowhere = search(axis(), lambda _: True), search(axis(), lambda _: False)

    assert (everywhere.holds_up_to, everywhere.fails_from) == (1.0, None)
    assert everywhere.describe() == "holds everywhere"
    assert (nowhere.holds_up_to, nowhere.fails_from) == (None, 0.0)
    assert nowhere.describe() == "fails from the lowest value on"
    assert everywhere.tried == nowhere.tried == 5


def test_of_two_failures_the_first_is_found_and_is_not_monotone() -> None:
    found = search(axis(scan=9), lambda value: value < 0.32 or 0.55 < value < 0.72)

    assert found.holds_up_to == pytest.approx(0.32, abs=0.01)
    assert not found.monotone
    assert "not monotone" in found.describe()


def test_failing_only_at_the_lowest_value_is_not_monotone() -> None:
    found = search(axis(), lambda value: value > 0.5)

    assert (found.holds_up_to, found.fails_from, found.monotone) == (None, 0.0, False)


def test_steps_count_halvings_of_one_part_of_the_scan() -> None:
    stepped = BisectAxis(name="d", key="a", kind="bisect", low=0, high=8, steps=3, scan=3)

    assert first_values(stepped) == [0.0, 2.0, 4.0, 6.0, 8.0]
    assert stepped.widest == 0.25
    assert search(stepped, lambda value: value < 5.1).tried == 5 + 3
