"""Places at which robots are drawn, against closed forms."""

from math import cos, hypot, sin

import numpy as np
import pytest
from passafe_services.scenarios.drawn_places import DrawnPlaces

from passafe.models.damped_point import damped_point
from passafe.models.seven_joint_arm import seven_joint_arm
from passafe.models.two_points import two_points
from passafe.models.unicycle import unicycle

NOSE = 0.4
CAR = DrawnPlaces.of(unicycle(nose_m=NOSE))
AT = [1.0, -2.0, 0.7, 0.9, -1.1]


def test_points_are_drawn_where_their_state_begins() -> None:
    places, heading, velocities = DrawnPlaces.of(two_points()).at([1, 2, 3, 4, 5, 6, 7, 8])

    assert places == [(1.0, 2.0), (3.0, 4.0)]
    assert heading is None
    assert velocities == [(5.0, 6.0), (7.0, 8.0)]


def test_car_is_drawn_at_its_place_with_the_speed_of_its_nose() -> None:
    places, heading, velocities = CAR.at(AT)

    assert places == [(1.0, -2.0)]
    assert heading == 0.7
    c, s = cos(0.7), sin(0.7)
    assert velocities[0] == pytest.approx((0.9 * c + NOSE * 1.1 * s, 0.9 * s - NOSE * 1.1 * c))


def test_many_states_are_those_of_one_at_a_time() -> None:
    states = np.random.default_rng(1).normal(size=(5, 7))

    one_by_one = [[*CAR.at(list(x))[0][0], CAR.at(list(x))[1]] for x in states.T]
    assert CAR.many(states).T.tolist() == one_by_one
    assert CAR.many(np.zeros((5, 0))).shape == (3, 0)


def test_input_of_a_car_pushes_its_nose() -> None:
    """R(θ)(u₁, ℓu₂)."""
    c, s = cos(0.7), sin(0.7)

    assert CAR.push(AT, (2.0, 3.0)) == pytest.approx((2 * c - 3 * NOSE * s, 2 * s + 3 * NOSE * c))
    assert CAR.reach(AT, 0, (c, s)) == pytest.approx(1.0)
    assert CAR.reach(AT, 0, (-s, c)) == pytest.approx(NOSE)
    assert CAR.reach(AT, 0, (1.0, 0.0)) == pytest.approx(hypot(c, NOSE * s))


def test_input_of_a_point_pushes_it_as_it_is() -> None:
    point = DrawnPlaces.of(damped_point())

    assert point.push((0.0,) * 4, (2.0, 3.0)) == (2.0, 3.0)
    assert point.reach((0.0,) * 4, 0, (1.0, 0.0)) == 1.0


def test_arm_is_not_drawn_in_the_plane() -> None:
    assert DrawnPlaces.of(seven_joint_arm()).count == 0
