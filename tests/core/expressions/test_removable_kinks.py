"""Kinks that cancel: of logsumexp, whose largest exponent the whole does not depend on."""

import casadi as ca
import numpy as np
import pytest

from passafe.enclosures.enclosure import enclose
from passafe.expressions.removable_kinks import without_removable_kinks

p = ca.SX.sym("p", 3)
SIDES = ca.vertcat(4 * p[0], -4 * p[0], 3 * p[1] + p[2], -5 * p[1])


def shifted(exponents: ca.SX, shift: ca.SX) -> ca.SX:
    return shift + ca.log(ca.sum1(ca.exp(exponents - shift)))


@pytest.mark.parametrize(
    ("e", "largest"),
    [
        (ca.logsumexp(SIDES), 1e4),
        (2 - ca.logsumexp(-SIDES) / 8, 1e4),
        (shifted(SIDES, ca.mmin(SIDES)), 10.0),
        (shifted(SIDES, ca.fabs(p[1])), 10.0),
        (ca.logsumexp(ca.vertcat(ca.logsumexp(SIDES[:2]), ca.logsumexp(SIDES[2:]))), 1e4),
        (ca.fabs(p[0]) * p[0] + ca.logsumexp(SIDES), 1e4),
    ],
)
def test_value_and_slope_stay_and_nothing_overflows(e: ca.SX, largest: float) -> None:
    smooth = without_removable_kinks(e)
    both = ca.Function("both", [p], [ca.horzcat(*(ca.vertcat(one, ca.gradient(one, p)) for one in (e, smooth)))])

    for scale in (0.0, 0.1, 1.0, largest):
        for at in np.random.default_rng(9).normal(scale=scale, size=(12, 3)):
            before, after = both(at).full().T
            assert after == pytest.approx(before, rel=1e-11, abs=1e-9)


def test_what_is_known_is_as_narrow_as_without_a_shift() -> None:
    radius, at = ca.SX(np.full(3, 0.01)), np.zeros(3)
    sizes = []
    for e in (without_removable_kinks(ca.logsumexp(SIDES)), ca.log(ca.sum1(ca.exp(SIDES))), ca.logsumexp(SIDES)):
        bend = ca.hessian(e, p)[0][0, 0]
        sizes.append(float(ca.Function("size", [p], [enclose(bend, p, radius).radius])(at)))

    assert sizes[0] == pytest.approx(sizes[1], rel=1e-9)
    assert sizes[0] < sizes[2] / 10


@pytest.mark.parametrize("e", [ca.fmax(p[0], p[1]), p[0] * ca.fabs(p[0]), ca.exp(-ca.fabs(p[2])) * 1e-3])
def test_other_kinks_are_left_alone(e: ca.SX) -> None:
    assert without_removable_kinks(e) is e
