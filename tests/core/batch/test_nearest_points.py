"""Guesses of nearest points: right wherever the certificate says so, and that is nearly everywhere."""

from itertools import combinations

import numpy as np
import pytest
from program_residuals import residuals_of
from random_programs import KINDS, random_programs, unit
from two_row_oracle import solve_exactly

from passafe.batch.nearest_points import NearestPoints
from passafe.certificate import Tolerance, accepts
from passafe.numerics.workspace import Array

TIGHT = Tolerance(residual=1e-9, gap=1e-9)


def found(programs: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Points (count, k) and multipliers (count, M) of programs of the same size."""
    (M, k), count = programs[0][0].shape, len(programs)
    points = NearestPoints(k, M, count)
    for element, (G, d) in enumerate(programs):
        points.rows[:, :, element], points.bounds[:, element] = G.T, d
    z, lam = np.full((k, count), np.nan), np.full((M, count), np.nan)
    with np.errstate(all="ignore"):
        points.find(z, lam)
    return z.T, lam.T


@pytest.mark.parametrize("size", [2, 3, 5])
def test_two_rows_are_solved_as_in_closed_form(size: int) -> None:
    programs = [(G, d) for _, G, d in random_programs(3, 1400, size, ("generic", "parallel", "duplicated"))]
    for (G, d), z, lam in zip(programs, *found(programs), strict=True):
        exact = solve_exactly(G, d)

        assert exact is not None
        assert z == pytest.approx(exact.z, rel=1e-9, abs=1e-9 * (1 + np.abs(d).max()))
        assert lam.min() >= 0.0
        assert z == pytest.approx(lam @ G, rel=1e-9, abs=1e-12)


def test_nasty_rows_are_right_or_fail_the_certificate() -> None:
    programs = [(G, d) for _, G, d in random_programs(4, 2100, 3, KINDS)]
    certified = 0
    for (G, d), z, lam in zip(programs, *found(programs), strict=True):
        if accepts(TIGHT, residuals_of(G, d, z, lam)):
            certified += 1
            exact = solve_exactly(G, d - 1e-9 * (1 + np.linalg.norm(z)))
            assert exact is not None
            assert np.linalg.norm(z) <= np.linalg.norm(exact.z) + 1e-4 * (1 + np.linalg.norm(z))
    assert certified > 0.6 * len(programs)


@pytest.mark.parametrize("M", [4, 9])
def test_among_many_rows_it_finds_what_one_or_two_of_them_decide(M: int) -> None:
    rng = np.random.default_rng(M)
    programs = [(np.array([unit(rng.normal(size=3)) for _ in range(M)]), rng.normal(size=M) - 1.0) for _ in range(500)]
    decided_by_two = right = 0
    for (G, d), z, lam in zip(programs, *found(programs), strict=True):
        nearest = nearest_by_trying(G, d)
        decided_by_two += nearest is not None
        if accepts(TIGHT, residuals_of(G, d, z, lam)):
            right += 1
            assert nearest is not None
            assert z == pytest.approx(nearest, abs=1e-7)
    assert right > 0.9 * decided_by_two


def nearest_by_trying(G: Array, d: Array) -> Array | None:
    """Return the nearest point with at most two active rows, by trying all of them."""
    kept = [np.zeros(G.shape[1])] if (d <= 1e-12).all() else []
    for pair in combinations(range(len(d)), 2):
        exact = solve_exactly(G[list(pair)], d[list(pair)])
        if exact is not None and (G @ exact.z >= d - 1e-9).all():
            kept.append(exact.z)
    return min(kept, key=lambda z: float(z @ z), default=None)


def test_unbounded_row_affects_its_own_element_alone() -> None:
    G = np.array([[1.0, 0.0], [0.0, 1.0]])
    programs = [(G, np.array([2.0, 1.0])), (G, np.array([np.nan, 1.0])), (G, np.array([0.5, -1.0]))]
    z, _ = found(programs)

    assert z[0] == pytest.approx([2.0, 1.0])
    assert not accepts(TIGHT, residuals_of(G, programs[1][1], z[1], np.zeros(2)))
    assert z[2] == pytest.approx([0.5, 0.0])
