from math import inf, nan

import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric, slope
from hypothesis import given
from hypothesis import strategies as st

from passafe.errors import DesignError, ShapeError
from passafe.shapes import disk_keep_out, half_plane

coordinates = st.floats(-1e3, 1e3)
points = st.tuples(coordinates, coordinates)
p = ca.SX.sym("p", 2)


@given(centre=points, radius=st.floats(1e-3, 1e3), angle=st.floats(0, 6.3), distance=st.floats(0, 1e3))
def test_disk_is_the_squared_distance_beyond_its_rim(
    centre: tuple[float, float], radius: float, angle: float, distance: float
) -> None:
    h = numeric([p], disk_keep_out(p, centre=centre, radius=radius))
    point = np.array(centre) + distance * np.array([np.cos(angle), np.sin(angle)])

    assert h(point)[0] == pytest.approx(distance**2 - radius**2, abs=1e-8 * (1 + distance**2 + np.hypot(*centre)))


@given(normal=points.filter(any), offset=coordinates, along=coordinates, across=coordinates)
def test_half_plane_grows_along_its_normal_only(
    normal: tuple[float, float], offset: float, along: float, across: float
) -> None:
    h = numeric([p], half_plane(p, normal=normal, offset=offset))
    n = np.array(normal)
    point = along * n + across * np.array([-n[1], n[0]])

    assert h(point)[0] == pytest.approx(along * n @ n - offset, abs=float(1e-9 * (1 + abs(point) @ abs(n))))


def test_half_plane_is_positive_where_the_normal_points() -> None:
    h = numeric([p], half_plane(p, normal=(1.0, 0.0), offset=2.0))

    assert h([3.0, 9.0])[0] == 1.0
    assert h([0.0, 9.0])[0] == -2.0


def test_balls_and_half_spaces_work_in_any_dimension() -> None:
    q = ca.SX.sym("q", 3)
    ball = numeric([q], disk_keep_out(q, centre=(1, 2, 3), radius=2))
    space = numeric([q], half_plane(q, normal=(1, 2, 3), offset=4))

    assert ball([1, 2, 6])[0] == 5.0
    assert space([1, 1, 1])[0] == 2.0
    assert slope(lambda at: ball(at)[0], [2, 3, 4]) == pytest.approx([2, 2, 2])


@pytest.mark.parametrize("radius", [0.0, -1.0, nan, inf])
def test_a_radius_is_positive_and_finite(radius: float) -> None:
    with pytest.raises(DesignError) as refused:
        disk_keep_out(p, centre=(0, 0), radius=radius)

    assert (refused.value.part, refused.value.got) == ("disk radius", radius)


@pytest.mark.parametrize("centre", [(0.0, nan), (inf, 0.0)])
def test_a_centre_is_finite(centre: tuple[float, float]) -> None:
    with pytest.raises(DesignError, match="disk centre"):
        disk_keep_out(p, centre=centre, radius=1.0)


@pytest.mark.parametrize("normal", [(0.0, 0.0), (nan, 1.0), (inf, 0.0)])
def test_a_normal_is_finite_and_not_zero(normal: tuple[float, float]) -> None:
    with pytest.raises(DesignError, match="half-plane normal"):
        half_plane(p, normal=normal, offset=0.0)


@pytest.mark.parametrize("offset", [nan, inf, -inf])
def test_an_offset_is_finite(offset: float) -> None:
    with pytest.raises(DesignError, match="half-plane offset"):
        half_plane(p, normal=(1.0, 0.0), offset=offset)


def test_vectors_have_one_number_for_each_coordinate() -> None:
    with pytest.raises(ShapeError) as of_centre:
        disk_keep_out(p, centre=(0, 0, 0), radius=1)
    with pytest.raises(ShapeError) as of_normal:
        half_plane(p, normal=(1,), offset=0)

    assert str(of_centre.value) == "disk centre: got 3 numbers, allowed 2, one for each coordinate"
    assert str(of_normal.value) == "half-plane normal: got 1 numbers, allowed 2, one for each coordinate"
