"""The rule for missing inputs, in closed form: an input is in force for so long, then comes u = −K x₂."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.messages import PlantPhase
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import damped_point
from passafe.limits import Limits
from passafe.models.robot import Robot

MS = 1_000_000
X = (2.0, 2.0, -1.0, 0.5)
U = (7.0, -3.0)
ROBOT: Robot = damped_point(sigma=1.0, gamma_1=10.0)
K = 9.0


def fail_safe(hold_ns: int, limits: Limits | None = None) -> FailSafe:
    return FailSafe(ROBOT, limits or Limits.of(2, 100.0), period_ns=MS, hold_ns=hold_ns)


def periods_in_force(rule: FailSafe, hold_ns: int | None = None) -> int:
    """Return for how many periods an input is in force that takes effect at plant time 40 ms."""
    periods = 1
    while rule.without_input(U, 40 * MS, (40 + periods) * MS, X, hold_ns)[0] is PlantPhase.HOLDING:
        periods += 1
    return periods


def test_the_law_brakes() -> None:
    assert fail_safe(0).law(X) == (-K * X[2], -K * X[3])


def test_the_law_stays_within_magnitude_and_norm() -> None:
    narrow = fail_safe(0, Limits.of(2, (2.0, 100.0)))
    short = fail_safe(0, Limits.of(2, 100.0, 5.0))

    assert narrow.law(X) == (2.0, -K * X[3])
    assert sum(value**2 for value in short.law((0.0, 0.0, -3.0, 4.0))) == pytest.approx(25.0, rel=1e-12)
    assert short.law((0.0, 0.0, -3.0, 4.0)) == pytest.approx((3.0, -4.0), rel=1e-12)


@pytest.mark.parametrize(
    ("hold_ns", "periods"),
    [(0, 1), (1, 1), (MS - 1, 1), (MS, 1), (2 * MS - 1, 1), (2 * MS, 2), (3 * MS, 3), (3 * MS + 1, 3), (10 * MS, 10)],
)
def test_input_is_held_for_hold_time_and_at_least_one_period(hold_ns: int, periods: int) -> None:
    assert periods_in_force(fail_safe(hold_ns)) == periods


def test_message_can_shorten_the_hold_time_not_extend_it() -> None:
    assert periods_in_force(fail_safe(5 * MS), hold_ns=3 * MS) == 3
    assert periods_in_force(fail_safe(5 * MS), hold_ns=0) == 1
    assert periods_in_force(fail_safe(5 * MS), hold_ns=2**64 - 1) == 5


def test_hold_returns_the_input_and_fail_safe_the_law() -> None:
    rule = fail_safe(3 * MS)

    assert rule.without_input(U, 0, 2 * MS, X) == (PlantPhase.HOLDING, U)
    assert rule.without_input(U, 0, 3 * MS, X) == (PlantPhase.FAIL_SAFE, (9.0, -4.5))


@given(st.tuples(*[st.floats(-50, 50)] * 4), st.integers(0, 40), st.integers(1, 60))
def test_two_of_them_agree_to_the_last_bit(x: tuple[float, ...], hold_ms: int, elapsed_ms: int) -> None:
    plants, filters = SAME[0], SAME[1]

    assert plants.law(x) == filters.law(x)
    assert plants.without_input(U, 0, elapsed_ms * MS, x, hold_ms * MS) == filters.without_input(
        U, 0, elapsed_ms * MS, x, hold_ms * MS
    )


SAME = fail_safe(10 * MS), fail_safe(10 * MS)


@given(st.integers(0, 10**9), st.integers(0, 10**9), st.integers(1, 10**9))
def test_once_it_failed_safe_it_never_holds_again(hold_ns: int, now_ns: int, later_ns: int) -> None:
    rule = SAME[0]
    if rule.without_input(U, 0, now_ns, X, hold_ns)[0] is PlantPhase.FAIL_SAFE:
        assert rule.without_input(U, 0, now_ns + later_ns, X, hold_ns)[0] is PlantPhase.FAIL_SAFE
