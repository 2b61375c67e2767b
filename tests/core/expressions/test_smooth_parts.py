"""Barriers with kinks: taken apart into smooth rows and branches, or refused with words."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
import pytest

from passafe.errors import DesignError
from passafe.expressions.slopes import broken_at
from passafe.expressions.smooth_parts import MOST_PARTS, smooth_parts

p = ca.SX.sym("p", 3)
t = ca.SX.sym("t")


def parts(h: ca.SX) -> tuple[tuple[ca.SX, ...], ...]:
    return smooth_parts("barrier 'odd' h", h)


@pytest.mark.parametrize(
    ("h", "branches"),
    [
        (ca.fmin(p[0], 2 * p[1]), [1, 1]),
        (ca.fmax(p[0], 2 * p[1]), [2]),
        (1 - ca.fabs(p[0]), [1, 1]),
        (ca.fabs(p[0]) - 1, [2]),
        (ca.sqrt((p[0] - 1) ** 2) + p[1], [2]),
        (ca.mmin(p), [1, 1, 1]),
        (2 - ca.mmax(p), [1, 1, 1]),
        (2 - ca.norm_1(p[:2]), [1, 1, 1, 1]),
        (2 - ca.norm_inf(p), [1] * 7),
        (ca.fmin(p[0], ca.fmax(p[1], p[2])), [1, 2]),
        (ca.fmax(ca.fmin(p[0], 1), ca.fmin(p[1], p[2])), [2, 2, 2, 2]),
        (-ca.fmin(ca.fmax(p[0], p[1]), p[2]), [2, 2]),
        (3 * ca.fmin(p[0], p[1]) / 2, [1, 1]),
        (ca.fmin(p[0], p[1]) / -2 + t, [2]),
        (2 * (ca.fmin(p[0], t) - ca.fmin(p[1], p[2])), [2, 2]),
        (ca.tanh(ca.fmin(p[0], p[1])) + ca.atan(ca.fmax(p[1], p[2])), [2, 2]),
        (ca.exp(ca.fabs(p[0])) - 2, [2]),
    ],
)
def test_an_expression_is_the_least_row_of_largest_branches(h: ca.SX, branches: Sequence[int]) -> None:
    rows = parts(h)
    whole = ca.Function("whole", [p, t], [h])
    apart = ca.Function("apart", [p, t], [ca.mmin(ca.vertcat(*(ca.mmax(ca.vertcat(*row)) for row in rows)))])

    assert [len(row) for row in rows] == branches
    assert all(broken_at(branch) is None for row in rows for branch in row)
    for at in np.random.default_rng(6).normal(scale=2.0, size=(60, 4)):
        assert float(apart(at[:3], at[3])) == pytest.approx(float(whole(at[:3], at[3])), rel=1e-14, abs=1e-14)


@pytest.mark.parametrize(
    "h",
    [
        2 - p[0] * ca.fabs(p[0]),
        1 - ca.fmax(p[0], 0) ** 2,
        ca.sin(p[0]) - p[1],
        ca.cos(p[1] * ca.fabs(p[1])),
        ca.fabs(p[0] - p[1]) ** 3,
        ca.sin(ca.fabs(p[0] ** 2 + 1)),
    ],
)
def test_what_has_a_slope_everywhere_is_one_part(h: ca.SX) -> None:
    ((branch,),) = parts(h)

    assert str(branch) == str(h)


def test_a_smooth_expression_is_returned_itself() -> None:
    h = 1 - ca.sumsqr(p)

    assert parts(h)[0][0] is h


@pytest.mark.parametrize(
    ("h", "kink"),
    [
        (ca.sin(ca.fabs(p[0])), r"fabs\(p_0\) inside sin"),
        (ca.fmin(p[0], p[1]) * p[2], r"fmin\(p_0,p_1\) inside \(fmin"),
        (4 / (1 + ca.fabs(p[1])), r"fabs\(p_1\) inside \(4/"),
        (p[2] / ca.fmax(p[0], 1), r"fmax\(p_0,1\) inside"),
        (ca.fmin(1, ca.fmax(p[0], p[1]) ** 2), r"fmax\(p_0,p_1\) inside sq"),
        (1 - 1e-4 * ca.cos(ca.fabs(p[0]) + p[1]), r"fabs\(p_0\) inside cos"),
    ],
)
def test_a_kink_inside_another_function_is_refused(h: ca.SX, kink: str) -> None:
    with pytest.raises(DesignError, match=rf"barrier 'odd' h: got {kink}.*no slope.*write sqrt\(e\*\*2 \+ 0\.01\)"):
        parts(h)


def test_too_many_parts_are_refused() -> None:
    corners = ca.SX.sym("q", 12)
    assert len(parts(ca.mmin(corners)) * 5) < MOST_PARTS

    with pytest.raises(DesignError, match=r"that make 128 parts or more, allowed 64 parts at most; write a smooth"):
        parts(1 - ca.norm_1(corners))


def test_a_kink_of_what_stays_is_none_of_what_moves() -> None:
    drive = p[0] * ca.fmin(ca.fmax(p[2], -5), 5)

    assert broken_at(drive, p[:2]) is None
    assert broken_at(drive) is not None


def test_a_kink_in_what_has_no_value_there_does_not_count() -> None:
    """The kink at p₀ = −1 lies where the root has no value."""
    assert broken_at(ca.sqrt(p[0]) * ca.fabs(p[0] + 1)) is None
