"""First-order follower against its solution in closed form."""

from math import exp

import pytest
from passafe_services.operator.sources.follower import Follower


def test_it_follows_the_exact_solution() -> None:
    follower = Follower(2, 0.05)
    follower.aim((4.0, -2.0))

    follower.advance(0.02)
    follower.advance(0.03)

    left = exp(-1.0)
    assert follower.value == pytest.approx((4.0 * (1 - left), -2.0 * (1 - left)), rel=1e-14)
    assert follower.rate == pytest.approx((4.0 * left / 0.05, -2.0 * left / 0.05), rel=1e-14)


def test_rest_is_at_once() -> None:
    follower = Follower(1, 0.05)
    follower.aim((4.0,))
    follower.advance(0.02)

    follower.rest()

    assert (follower.value, follower.target, follower.rate) == ((0.0,), (0.0,), (0.0,))
