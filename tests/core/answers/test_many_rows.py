"""Hundreds of rows, and rows that repeat or face one another."""

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import gains, paper_design
from finite_differences import Array

from passafe.barrier_chain import Barrier
from passafe.decision import Decision, Status
from passafe.design import Mode
from passafe.filter import SafetyPassivityFilter

ZERO = (0.0, 0.0)
POLYGON = 250


def between_walls(normals: Sequence[Sequence[float]], distances: Sequence[float]) -> SafetyPassivityFilter:
    """Return a filter that keeps the paper's robot on the inner side of walls nᵀp ≤ distance."""
    design = paper_design(mode=Mode.SAFE)
    position = design.system.x[:2]
    walls = tuple(
        Barrier(name=f"wall {i}", h=distance - ca.dot(ca.DM(list(normal)), position), class_k=gains(5.0, 5.0, 5.0))
        for i, (normal, distance) in enumerate(zip(normals, distances, strict=True))
    )
    return SafetyPassivityFilter(replace(design, barriers=walls))


@pytest.fixture(scope="module")
def polygon() -> SafetyPassivityFilter:
    angles = np.linspace(0, 2 * np.pi, POLYGON, endpoint=False)
    return between_walls(np.column_stack((np.cos(angles), np.sin(angles))).tolist(), [1.0] * POLYGON)


def nearest_of_all_corners_and_edges(decision: Decision) -> Array:
    """Return the nearest z that keeps the rows, by trying every row alone and every two together."""
    d = decision.part("d")
    G = decision.part("G").reshape((d.size, 2), order="F")
    i, j = np.triu_indices(d.size, 1)
    determinant = G[i, 0] * G[j, 1] - G[i, 1] * G[j, 0]
    i, j, determinant = (each[np.abs(determinant) > 1e-9] for each in (i, j, determinant))
    corners = np.array([d[i] * G[j, 1] - d[j] * G[i, 1], d[j] * G[i, 0] - d[i] * G[j, 0]]) / determinant
    tried = np.hstack((np.zeros((2, 1)), (G * d[:, None]).T, corners))
    kept = tried[:, (G @ tried >= d[:, None] - 1e-9).all(axis=0)]
    return np.asarray(kept[:, np.argmin((kept**2).sum(axis=0))])


def test_polygon_of_250_walls_is_kept_by_the_nearest_input(polygon: SafetyPassivityFilter) -> None:
    rng = np.random.default_rng(95)
    modified = 0
    for _ in range(60):
        angle, speed = rng.uniform(0, 2 * np.pi, 2)
        x = [0.9 * np.cos(angle), 0.9 * np.sin(angle), 0.3 * np.cos(speed), 0.3 * np.sin(speed)]
        decision = polygon.decide(x, ZERO, (60 * rng.normal(size=2)).tolist(), ZERO)
        assert decision.status in {Status.PASSED, Status.MODIFIED}
        if decision.status is Status.MODIFIED:
            modified += 1
            assert decision.part("z") == pytest.approx(nearest_of_all_corners_and_edges(decision), abs=1e-4)
    assert modified > 10


def test_250_rows_take_hostile_numbers(polygon: SafetyPassivityFilter) -> None:
    for value in (float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 5e-324, 1e154):
        for place in range(4):
            x = [0.1, 0.2, 0.3, 0.4]
            x[place] = value
            decision = polygon.decide(x, ZERO, ZERO, ZERO)

            assert np.isfinite(decision.u).all()
            assert np.abs(decision.u).max() <= 100.0
            assert abs(value) < 1 or decision.status.is_fallback


def test_the_same_wall_twice_is_one_wall() -> None:
    once, twice = between_walls([(1.0, 0.0)], [1.0]), between_walls([(1.0, 0.0)] * 7, [1.0] * 7)
    request = ([0.95, 0.0, 0.2, 0.1], ZERO, (80.0, 0.0), ZERO)

    assert twice.decide(*request).status is Status.MODIFIED
    assert twice.decide(*request).u == pytest.approx(once.decide(*request).u, abs=1e-6)


def test_walls_that_face_one_another_leave_the_slit_between_them() -> None:
    """Two walls, 2 mm apart from one another: the rows leave an interval for u₀, and none once they overlap."""
    slit, closed = (between_walls([(1.0, 0.0), (-1.0, 0.0)], [width, width]) for width in (1e-3, -1e-3))
    request = ([0.0, 0.0, 0.0, 0.1], ZERO, (80.0, 3.0), ZERO)
    decision = slit.decide(*request)

    assert decision.status is Status.MODIFIED
    assert 0 <= decision.u[0] <= 25 * 1e-3
    assert closed.decide(*request).status is Status.INFEASIBLE
