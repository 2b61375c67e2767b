from collections.abc import Callable
from math import inf, nan

import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric, slope
from hypothesis import given
from hypothesis import strategies as st

from passafe.barriers import (
    box,
    circular_motion,
    disk_keep_in,
    disk_keep_out,
    ellipse_keep_in,
    ellipse_keep_out,
    half_plane,
    oscillating_motion,
    separation,
    speed_limit,
    uniform_motion,
)
from passafe.errors import DesignError, ShapeError
from passafe.storage import spring_energy

coordinates = st.floats(-1e3, 1e3)
points = st.tuples(coordinates, coordinates)
p = ca.SX.sym("p", 2)
t = ca.SX.sym("t")


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

    assert (refused.value.field, refused.value.got) == ("disk radius", radius)


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


@given(centre=points, radius=st.floats(1e-3, 1e3), turn=st.floats(-7, 7), at=points)
def test_ellipse_with_equal_semi_axes_is_a_disk(
    centre: tuple[float, float], radius: float, turn: float, at: tuple[float, float]
) -> None:
    shape = ellipse_keep_out(p, centre=centre, semi_axes=(radius, radius), rotation_rad=turn)
    ellipse, disk = numeric([p], shape), numeric([p], disk_keep_out(p, centre=centre, radius=radius))

    assert ellipse(at)[0] == pytest.approx(disk(at)[0], abs=1e-9 * (1 + np.hypot(*centre) + np.hypot(*at)) ** 2)


@given(at=points, turn=st.floats(-7, 7))
def test_what_is_kept_in_is_the_opposite_of_what_is_kept_out(at: tuple[float, float], turn: float) -> None:
    ellipse = {"centre": (1, 2), "semi_axes": (3, 4), "rotation_rad": turn}
    out = ca.vertcat(disk_keep_out(p, centre=(1, 2), radius=3), ellipse_keep_out(p, **ellipse))
    into = ca.vertcat(disk_keep_in(p, centre=(1, 2), radius=3), ellipse_keep_in(p, **ellipse))

    assert (numeric([p], out)(at) == -numeric([p], into)(at)).all()


def test_the_semi_axes_are_where_the_ellipse_ends() -> None:
    h = numeric([p], ellipse_keep_out(p, centre=(1, 2), semi_axes=(3, 0.5), rotation_rad=np.pi / 2))

    assert h([1, 5])[0] == pytest.approx(0)
    assert h([0.5, 2])[0] == pytest.approx(0)
    assert h([1, 2])[0] == pytest.approx(-0.25)
    assert h([2, 2])[0] == pytest.approx(0.75)  # 1² − 0.5², as for the disk along the shortest semi-axis


def test_an_ellipsoid_has_any_number_of_semi_axes() -> None:
    q = ca.SX.sym("q", 3)
    h = numeric([q], ellipse_keep_out(q, centre=(0, 0, 0), semi_axes=(1, 2, 3)))

    assert h([0, 0, 3])[0] == pytest.approx(0)
    assert h([0, 4, 0])[0] == pytest.approx(3)
    with pytest.raises(DesignError, match=r"ellipse rotation_rad: got 1\.0, allowed 0 with 3"):
        ellipse_keep_out(q, centre=(0, 0, 0), semi_axes=(1, 2, 3), rotation_rad=1.0)


def test_a_box_has_two_sides_for_every_coordinate() -> None:
    sides = numeric([p], ca.vertcat(*box(p, low=(-1, -2), high=(3, 4))))

    assert sides([0, 1]).tolist() == [1, 3, 3, 3]
    assert sides([-5, 9]).tolist() == [-4, 8, 11, -5]


def test_speed_limit_and_separation_are_differences_of_squares() -> None:
    q = ca.SX.sym("q", 2)

    assert numeric([p], speed_limit(p, limit=6))([3, 4])[0] == 11
    assert numeric([p, q], separation(p, q, distance=2))([1, 1], [4, 5])[0] == 21


def test_motions_are_where_they_should_be() -> None:
    assert numeric([t], uniform_motion(t, velocity=(2, -1)))(1.5).tolist() == [3, -1.5]
    swing = numeric([t], oscillating_motion(t, amplitude=(2, -1), frequency_hz=0.25))
    assert swing(1) == pytest.approx([2, -1])
    assert swing(2) == pytest.approx([0, 0])
    circle = numeric([t], circular_motion(t, radius=2, frequency_hz=0.5, phase_rad=np.pi / 2))
    assert circle(0) == pytest.approx([0, 2])
    assert circle(0.5) == pytest.approx([-2, 0])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: disk_keep_in(p, centre=(0, 0), radius=0), "disk radius: got 0, allowed a positive finite number, m"),
        (
            lambda: ellipse_keep_in(p, centre=(0, 0), semi_axes=(1, 0)),
            "ellipse semi_axes: got 0, allowed a positive finite number, m",
        ),
        (
            lambda: ellipse_keep_out(p, centre=(0, 0), semi_axes=(1, 1), rotation_rad=inf),
            "ellipse rotation_rad: got inf, allowed a finite number, rad",
        ),
        (lambda: ellipse_keep_out(p, centre=(0, 0), semi_axes=(1,)), "ellipse semi_axes: got 1 numbers"),
        (
            lambda: box(p, low=(0, 0), high=(1, 0)),
            "box low, high: got [0, 0], [1, 0], allowed every high above its low",
        ),
        (lambda: box(p, low=(0,), high=(1, 1)), "box low: got 1 numbers, allowed 2, one for each coordinate"),
        (lambda: box(p.T, low=(0, 0), high=(1, 1)), "coordinates of box low: got shape (1, 2), allowed a column"),
        (lambda: speed_limit(p, limit=nan), "speed limit: got nan, allowed a positive finite number, m/s"),
        (lambda: speed_limit(p.T, limit=1), "speed limit velocity: got shape (1, 2), allowed a column"),
        (lambda: separation(p, p, distance=-1), "separation distance: got -1, allowed a positive finite number, m"),
        (
            lambda: separation(p, p[0], distance=1),
            "separation positions: got shapes (2, 1) and (1, 1), allowed two columns of equal length",
        ),
        (lambda: uniform_motion(p, velocity=(1, 1)), "motion t: got shape (2, 1), allowed a scalar"),
        (lambda: uniform_motion(t, velocity=()), "uniform motion velocity: got no numbers, allowed at least one"),
        (lambda: uniform_motion(t, velocity=(inf,)), "uniform motion velocity: got [inf], allowed finite numbers"),
        (
            lambda: oscillating_motion(t, amplitude=(1,), frequency_hz=0),
            "motion frequency_hz: got 0, allowed a positive finite number, Hz",
        ),
        (
            lambda: oscillating_motion(t, amplitude=(1,), frequency_hz=1, phase_rad=nan),
            "motion phase_rad: got nan, allowed a finite number, rad",
        ),
        (
            lambda: circular_motion(t, radius=0, frequency_hz=1),
            "circular motion radius: got 0, allowed a positive finite number, m",
        ),
        (
            lambda: spring_energy(p, p, stiffness=0),
            "spring stiffness: got 0, allowed a positive finite number, 1/s²",
        ),
    ],
)
def test_what_makes_no_shape_is_refused_with_what_is_allowed(build: Callable[[], object], message: str) -> None:
    with pytest.raises(DesignError) as refused:
        build()

    assert str(refused.value).startswith(message)
