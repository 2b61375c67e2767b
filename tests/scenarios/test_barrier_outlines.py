"""Outlines against the h of their barriers."""

import itertools
from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.barrier_kinds.ellipse import EllipseBarrier
from passafe_services.scenarios.barrier_kinds.half_plane import HalfPlaneBarrier
from passafe_services.scenarios.barrier_kinds.motion import Swing
from passafe_services.scenarios.barrier_kinds.point_barrier import PlaceBarrier
from passafe_services.scenarios.class_k import ClassKConfig

CHAIN = (ClassKConfig(kind="linear", gain=1.0),)
normals = st.tuples(st.floats(-5, 5), st.floats(-5, 5)).filter(lambda n: n[0] ** 2 + n[1] ** 2 > 1e-4)


def ellipse(kind: str, semi_axes: tuple[float, float], rotation_rad: float) -> EllipseBarrier:
    fields = {"centre": (0.5, 1.0), "semi_axes_m": semi_axes, "rotation_rad": rotation_rad}
    return EllipseBarrier.model_validate({"kind": kind, "name": kind, "class_k": CHAIN, **fields})


def wall(normal: tuple[float, float], offset: float) -> HalfPlaneBarrier:
    return HalfPlaneBarrier(kind="half-plane", name="wall", normal=normal, offset=offset, class_k=CHAIN)


PLACES: list[PlaceBarrier] = [
    DiskBarrier(kind="disk-keep-out", name="disk", centre=(1.0, -2.0), radius=0.7, class_k=CHAIN),
    DiskBarrier(kind="disk-keep-in", name="arena", centre=(1.0, -2.0), radius=3.0, class_k=CHAIN),
    ellipse("ellipse-keep-out", (2.0, 0.5), 0.6),
    ellipse("ellipse-keep-in", (4.0, 2.0), -1.2),
    wall((3.0, -4.0), 2.0),
]


@cache
def compiled(barrier: PlaceBarrier) -> ca.Function:
    p = ca.SX.sym("p", 2)
    return ca.Function("h", [p], [barrier.h_at(p)])


def h(barrier: PlaceBarrier, p: tuple[float, float]) -> float:
    return float(compiled(barrier)(p))


def covers(polygon: tuple[tuple[float, float], ...], p: tuple[float, float]) -> bool:
    """Check whether a ray from p crosses the polygon an odd number of times."""
    odd = False
    for (x1, y1), (x2, y2) in itertools.pairwise((*polygon, polygon[0])):
        if (y1 > p[1]) != (y2 > p[1]) and p[0] < x1 + (p[1] - y1) / (y2 - y1) * (x2 - x1):
            odd = not odd
    return odd


@pytest.mark.parametrize("barrier", PLACES, ids=lambda barrier: barrier.name)
def test_border_is_where_h_is_zero(barrier: PlaceBarrier) -> None:
    assert max(abs(h(barrier, p)) for p in barrier.outline.border) < 1e-9 * 200


@pytest.mark.parametrize("barrier", PLACES, ids=lambda barrier: barrier.name)
def test_unsafe_polygon_covers_what_is_unsafe(barrier: PlaceBarrier) -> None:
    rng = np.random.default_rng(1)
    polygon = barrier.outline.unsafe
    filled = 0
    for p in rng.uniform(-6, 6, (2000, 2)).tolist():
        value = h(barrier, p)
        if abs(value) > 0.1:
            assert covers(polygon, tuple(p)) is (value < 0)
            filled += value < 0
    assert filled > 10


@pytest.mark.parametrize("barrier", PLACES[:4], ids=lambda barrier: barrier.name)
def test_bounded_border_closes_and_stays_close_to_the_curve(barrier: PlaceBarrier) -> None:
    line = barrier.outline.border
    assert line[0] == pytest.approx(line[-1])
    assert barrier.outline.is_closed
    middles = [((x1 + x2) / 2, (y1 + y2) / 2) for (x1, y1), (x2, y2) in itertools.pairwise(line)]
    assert max(abs(h(barrier, p)) for p in middles) < 0.03


@given(normals, st.floats(-5, 5))
def test_wall_covers_its_unsafe_side(normal: tuple[float, float], offset: float) -> None:
    length = float(np.hypot(*normal))
    barrier = wall(normal, offset * length)
    outline = barrier.outline
    on_line, behind = outline.unsafe[:2], outline.unsafe[2:]
    assert on_line == outline.border
    assert all(abs(h(barrier, corner)) <= 1e-9 * length * 200 for corner in on_line)
    assert all(h(barrier, corner) == pytest.approx(-100.0 * length) for corner in behind)
    middle = np.mean(on_line, axis=0)
    assert np.hypot(*middle) == pytest.approx(abs(offset), abs=1e-9)
    assert np.hypot(*outline.reference) == pytest.approx(abs(offset), abs=1e-9)


def test_reference_of_a_disk_or_an_ellipse_is_its_centre() -> None:
    assert PLACES[0].outline.reference == (1.0, -2.0)
    assert PLACES[3].outline.reference == (0.5, 1.0)


def test_only_sets_to_keep_out_of_are_bounded() -> None:
    assert [barrier.outline.is_bounded for barrier in PLACES] == [True, False, True, False, False]
    assert [barrier.outline.is_closed for barrier in PLACES] == [True, True, True, True, False]


def test_outline_moves_with_its_barrier() -> None:
    swing = Swing(kind="swing", amplitude_m=(2.0, -1.0), frequency_hz=0.25)
    moving = PLACES[0].model_copy(update={"motion": swing})
    times_s = np.array([0.0, 1.0, 2.0, 3.0])
    assert moving.outline.displacements_m(times_s) == pytest.approx(np.array([[0, 2, 0, -2], [0, -1, 0, 1]]))
    assert not PLACES[0].outline.displacements_m(times_s).any()
    assert moving.outline.border == PLACES[0].outline.border
