import itertools
from math import hypot

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.obstacles import Disk, Ellipse, HalfPlane, Region
from passafe_dashboard.outlines import border, reference, shifted, unsafe_side

normals = st.tuples(st.floats(-5, 5), st.floats(-5, 5)).filter(lambda n: n[0] ** 2 + n[1] ** 2 > 1e-4)
REGIONS: list[Region] = [
    Disk(name="disk", centre=(1.0, -2.0), radius=0.7),
    Disk(name="arena", centre=(1.0, -2.0), radius=3.0, keep_in=True),
    Ellipse(name="post", centre=(0.5, 1.0), semi_axes=(2.0, 0.5), rotation_rad=0.6),
    Ellipse(name="track", centre=(0.5, 1.0), semi_axes=(4.0, 2.0), rotation_rad=-1.2, keep_in=True),
    HalfPlane(name="wall", normal=(3.0, -4.0), offset=2.0),
]


def covers(polygon: tuple[tuple[float, float], ...], p: tuple[float, float]) -> bool:
    """Whether a ray from p crosses the polygon's line an odd number of times."""
    odd = False
    for (x1, y1), (x2, y2) in itertools.pairwise((*polygon, polygon[0])):
        if (y1 > p[1]) != (y2 > p[1]) and p[0] < x1 + (p[1] - y1) / (y2 - y1) * (x2 - x1):
            odd = not odd
    return odd


@pytest.mark.parametrize("region", REGIONS, ids=lambda region: region.name)
def test_a_border_is_where_h_is_zero(region: Region) -> None:
    assert max(abs(region.h(p)) for p in border(region)) < 1e-9 * 200


@pytest.mark.parametrize("region", REGIONS, ids=lambda region: region.name)
def test_what_is_filled_is_what_is_unsafe(region: Region) -> None:
    rng = np.random.default_rng(1)
    polygon = unsafe_side(region)
    filled = 0
    for p in rng.uniform(-6, 6, (2000, 2)):
        if abs(region.h(p)) > 0.1:
            assert covers(polygon, tuple(p)) is bool(region.h(p) < 0)
            filled += region.h(p) < 0
    assert filled > 10


@pytest.mark.parametrize("region", REGIONS[:4], ids=lambda region: region.name)
def test_a_bounded_border_closes_and_stays_close_to_the_curve(region: Region) -> None:
    line = border(region)
    assert line[0] == pytest.approx(line[-1])
    middles = [((x1 + x2) / 2, (y1 + y2) / 2) for (x1, y1), (x2, y2) in itertools.pairwise(line)]
    assert max(abs(region.h(p)) for p in middles) < 0.03


@given(normals, st.floats(-5, 5))
def test_a_wall_covers_its_forbidden_side(normal: tuple[float, float], offset: float) -> None:
    length = float(np.hypot(*normal))
    wall = HalfPlane(name="wall", normal=normal, offset=offset * length)
    corners = unsafe_side(wall)
    on_line, behind = corners[:2], corners[2:]
    assert all(abs(wall.h(corner)) <= 1e-9 * length * 200 for corner in on_line)
    assert all(wall.h(corner) == pytest.approx(-100.0 * length) for corner in behind)
    middle = np.mean(on_line, axis=0)
    assert np.hypot(*middle) == pytest.approx(abs(offset), abs=1e-9)
    assert hypot(*reference(wall)) == pytest.approx(abs(offset), abs=1e-9)


def test_the_reference_of_a_disk_is_its_centre() -> None:
    assert reference(REGIONS[0]) == (1.0, -2.0)
    assert reference(REGIONS[3]) == (0.5, 1.0)


def test_a_line_is_shifted_as_a_whole() -> None:
    assert shifted(((0.0, 0.0), (1.0, 2.0)), (3.0, -1.0)) == ((3.0, -1.0), (4.0, 1.0))
