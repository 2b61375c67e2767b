import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric

from passafe.errors import DesignError, ShapeError
from passafe.limits import Limits


def interval(limits: Limits, u: list[float], dt_s: float) -> tuple[list[float], list[float]]:
    before = ca.SX.sym("u", len(u))
    low, high = (numeric([before], edge)(u).tolist() for edge in limits.interval(before, dt_s))
    return low, high


def clip(limits: Limits, u_plus: list[float], low: list[float], high: list[float], u: list[float]) -> list[float]:
    symbols = [ca.SX.sym(name, len(u_plus)) for name in ("u_plus", "u", "low", "high")]
    symbolic: list[float] = numeric(symbols, limits.clip(*symbols))(u_plus, u, low, high).tolist()
    plain = limits.nearest(*(np.array(each) for each in (u_plus, u, low, high)))
    assert plain == pytest.approx(symbolic)
    return symbolic


def test_one_number_counts_for_every_axis() -> None:
    limits = Limits.of(3, 2.0, None, 5.0)

    assert (limits.magnitude, limits.norm, limits.rise_per_s) == ((2.0, 2.0, 2.0), None, (5.0, 5.0, 5.0))
    assert (limits.low, limits.high, limits.fall_per_s) == ((-2.0,) * 3, (2.0,) * 3, (5.0,) * 3)
    assert Limits.of(2, (1.0, 4.0), 3.0, None).magnitude == (1.0, 4.0)


@pytest.mark.parametrize("value", [0.0, -1.0, float("inf"), float("nan")])
def test_limits_are_positive_and_finite(value: float) -> None:
    for arguments in ((value, None, None), (1.0, value, None), (1.0, None, value), ((1.0, value), None, None)):
        with pytest.raises(DesignError, match="positive finite"):
            Limits.of(2, *arguments)


def test_there_is_a_limit_for_every_axis() -> None:
    with pytest.raises(ShapeError, match="input_bound: got 3 numbers"):
        Limits.of(2, (1.0, 1.0, 1.0), None, None)


def test_the_interval_is_magnitude_and_rate_together() -> None:
    limits = Limits.of(2, (3.0, 1.0), None, 20.0)

    assert interval(limits, [2.5, 0.0], 0.1) == ([0.5, -1.0], [3.0, 1.0])
    assert interval(Limits.of(2, 3.0, None, None), [2.5, 0.0], 0.1) == ([-3.0, -3.0], [3.0, 3.0])


def test_magnitudes_take_precedence_over_rates() -> None:
    assert interval(Limits.of(2, 1.0, None, 1.0), [9.0, -9.0], 0.1) == ([1.0, -1.0], [1.0, -1.0])


def test_clip_goes_by_axis_then_towards_the_previous_input() -> None:
    limits = Limits.of(2, 4.0, 2.5, None)
    low, high = [-4.0, -4.0], [4.0, 4.0]

    assert clip(limits, [6.0, -3.0], low, high, [0.0, 0.0]) == pytest.approx([2.0, -1.5])
    assert clip(limits, [4.0, 2.0], low, high, [0.0, 2.0]) == pytest.approx([1.5, 2.0])
    assert clip(limits, [1.0, 1.0], low, high, [0.0, 2.0]) == [1.0, 1.0]
    assert clip(limits, [6.0, -3.0], low, high, [9.0, 9.0]) == pytest.approx([2.0, -1.5])  # that one is too long itself
    assert clip(Limits.of(2, 4.0, None, None), [6.0, -3.0], [-1.0, -1.0], [1.0, 1.0], [0.0, 0.0]) == [1.0, -1.0]


def test_what_is_clipped_keeps_norm_and_rate_together() -> None:
    limits = Limits.of(3, 5.0, 4.0, 10.0)
    rng = np.random.default_rng(92)
    for _ in range(200):
        u = rng.normal(size=3)
        u *= rng.uniform(0, 4) / np.linalg.norm(u)
        low, high = (np.array(edge) for edge in interval(limits, u.tolist(), 0.1))
        clipped = np.array(clip(limits, (9 * rng.normal(size=3)).tolist(), low.tolist(), high.tolist(), u.tolist()))

        assert np.linalg.norm(clipped) <= 4.0 * (1 + 1e-12)
        assert (clipped >= low - 1e-12).all()
        assert (clipped <= high + 1e-12).all()


def test_what_is_no_number_becomes_the_nearest_to_zero() -> None:
    limits = Limits.of(2, 4.0, None, None)
    low, high, zero = np.array([-4.0, 1.0]), np.array([4.0, 2.0]), np.zeros(2)

    assert limits.nearest(np.array([np.nan, np.nan]), zero, low, high).tolist() == [0.0, 1.0]
    assert limits.nearest(np.array([np.inf, -np.inf]), zero, low, high).tolist() == [4.0, 1.0]


def test_the_reach_is_the_longest_way_within_the_limits() -> None:
    assert Limits.of(2, (3.0, 4.0), None, None).reach == 10.0
    assert Limits.of(2, (3.0, 4.0), 2.0, None).reach == 10.0  # what is wished for may be longer than the norm


@pytest.mark.parametrize("beyond", [0.0, 4e-15])
def test_a_hair_beyond_the_norm_does_not_cost_the_rate(beyond: float) -> None:
    """Led towards zero, u⁺ = (2, 5) would become (1.86, 4.64), beyond the rate's low of 2; it goes towards u."""
    limits = Limits.of(2, 10.0, 5.0, 1.0)
    u_plus = clip(limits, [2.0, 5.0], [2.0, 3.0], [4.0, 5.0], [3.0, 4.0 + beyond])

    assert 2.0 <= u_plus[0] <= 4.0
    assert np.hypot(*u_plus) == pytest.approx(5.0, rel=1e-12)


@pytest.mark.parametrize("beyond", [0.0, 4e-15])
def test_away_from_the_norm_u_stays_where_it_is(beyond: float) -> None:
    assert clip(Limits.of(2, 10.0, 5.0, 1.0), [4.0, 5.0], [2.0, 3.0], [4.0, 5.0], [3.0, 4.0 + beyond]) == pytest.approx(
        [3.0, 4.0], rel=1e-12
    )
