"""Norms in barriers: the same set, with a slope at the centre too."""

import casadi as ca
import numpy as np
import pytest

from passafe.expressions.norms import without_singular_points

p = ca.SX.sym("p", 2)
t = ca.SX.sym("t")


def evaluated(h: ca.SX, at: object) -> np.ndarray:
    """Return value and gradient."""
    seen = ca.vertcat(h, ca.gradient(h, p))
    values: np.ndarray = ca.Function("seen", [p, t], [ca.densify(seen)])(at, 0.3).full().ravel()
    return values


@pytest.mark.parametrize(
    "h",
    [
        1.5 - ca.norm_2(p),
        1.5 - ca.sqrt(ca.sumsqr(p) + 1e-6),
        1.2 - 2 * ca.hypot(p[0], p[1]) / 3,
        0.9 - ca.sqrt(2 * p[0] ** 2 + 3 * p[1] ** 2 + p[0] ** 2 / 4),
        0.8 - ca.norm_2(p - ca.vertcat(ca.sin(t), 0.1)),
        0.4 + ca.sumsqr(p - 2) / 20 + ca.exp(-t) - ca.norm_2(p),
        0.3 + ca.hypot(p[0] - 9, t) / 90 - ca.norm_2(p),
        5 * (0.3 - ca.sqrt(ca.fabs(p[0]) ** 2 + ca.sqrt(p[1] ** 4))),
    ],
)
def test_a_ball_s_set_and_boundary_slope_are_kept(h: ca.SX) -> None:
    smooth = without_singular_points(h)
    ring = [np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0.1, 6.2, 12)]
    level = ca.Function("h", [p, t], [h])

    bend = ca.Function("bend", [p, t], [ca.norm_fro(ca.densify(ca.hessian(smooth, p)[0]))])

    assert np.isfinite([evaluated(smooth, at) for at in ([0, 0], [np.sin(0.3), 0.1], [1e-160, -0.0])]).all()
    assert max(float(bend(at, 0.3)) for at in ([0.01, 0.0], [np.sin(0.3), 0.11])) < 40
    for at in (radius * direction for radius in np.linspace(0.05, 3.0, 40) for direction in ring):
        value = float(level(at, 0.3))
        assert np.sign(evaluated(smooth, at)[0]) == np.sign(value) or abs(value) < 1e-12
        assert evaluated(smooth, at)[0] <= value + 1e-15
    for direction in ring:
        low, high = 1e-3, 4.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if float(level(middle * direction, 0.3)) > 0 else (low, middle)
        assert evaluated(smooth, low * direction) == pytest.approx(evaluated(h, low * direction), abs=1e-9)


@pytest.mark.parametrize(
    "h",
    [
        ca.norm_2(p) - 0.5,
        2 - ca.norm_2(p) - ca.norm_2(p - 1),
        1 + p[0] / 10 - ca.norm_2(p),
        ca.sumsqr(p - 2) / 20 - ca.norm_2(p),
        1 - ca.exp(-ca.norm_2(p)),
        ca.sqrt(ca.norm_2(p)) - 0.2,
        ca.sqrt(ca.sumsqr(p) * (1 + p[0] ** 2)) - 1,
        -1 - ca.norm_2(p),
    ],
)
def test_other_norms_keep_their_value_and_get_a_slope(h: ca.SX) -> None:
    smooth = without_singular_points(h)

    assert np.isfinite([evaluated(smooth, at) for at in ([0, 0], [1, 1])]).all()
    for at in np.random.default_rng(8).normal(size=(40, 2)):
        assert evaluated(smooth, at) == pytest.approx(evaluated(h, at), rel=1e-13, abs=1e-13)


@pytest.mark.parametrize(
    "h", [1 - ca.sumsqr(p), 3 - ca.sqrt(1 + p[0] ** 2), ca.sqrt(2 * p[0]) - p[1], 1 - ca.sqrt(p[0] * p[1])]
)
def test_what_has_no_singular_norm_is_left_alone(h: ca.SX) -> None:
    assert without_singular_points(h) is h
