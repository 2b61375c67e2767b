"""Courses of the robot compared: which keeps every barrier longer, and which loses them less."""

from dataclasses import replace
from math import inf

import pytest

from passafe.courses.course import EQUAL, KEPT, Course

LOST = Course(kept_periods=3.0, lowest=-0.5, proven=-0.5, soon=-0.25, lowest_at=70, is_proven=True, comes_to_rest=True)
ENDLESS = replace(LOST, lowest=-inf, comes_to_rest=False)


def test_a_course_is_no_worse_than_itself() -> None:
    for course in (KEPT, LOST, ENDLESS):
        assert course.is_no_worse_than(course)


def test_a_later_loss_counts_before_a_smaller_one() -> None:
    later = replace(LOST, kept_periods=4.0)
    assert later.is_no_worse_than(LOST)
    assert not LOST.is_no_worse_than(later)
    assert not replace(later, lowest=-1.0).is_no_worse_than(LOST)


@pytest.mark.parametrize(("factor", "expected"), [(1.0 + EQUAL / 2, True), (1.0 + 2 * EQUAL, False)])
def test_equal_losses_differ_by_rounding_alone(factor: float, *, expected: bool) -> None:
    deeper = replace(LOST, lowest=LOST.lowest * factor)
    assert deeper.is_no_worse_than(LOST) is expected


def test_of_courses_without_end_the_loss_soon_after_counts() -> None:
    deeper = replace(ENDLESS, soon=-0.3)
    assert ENDLESS.is_no_worse_than(deeper)
    assert not deeper.is_no_worse_than(ENDLESS)
    assert replace(LOST, soon=-0.3).is_no_worse_than(LOST), "both have an end"


def test_a_course_that_keeps_everything_is_safe_if_proven() -> None:
    assert KEPT.is_safe
    assert not replace(KEPT, is_proven=False).is_safe
    assert not replace(KEPT, comes_to_rest=False).is_safe
    assert not LOST.is_safe
    assert not replace(KEPT, proven=-1e-12).is_safe


@pytest.mark.parametrize(
    ("proven", "is_proven", "expected"), [(-1.0, True, True), (-1e5, True, False), (0.5, False, False)]
)
def test_a_bound_far_below_the_estimate_says_nothing(proven: float, *, is_proven: bool, expected: bool) -> None:
    course = replace(KEPT, lowest=1.0, proven=proven, is_proven=is_proven)
    assert course.is_bounded(replace(KEPT, lowest=0.5)) is expected
