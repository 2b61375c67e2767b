"""Decisions, steps and error sets that several threads ask one object for."""

import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from cart_designs import CART, X, cart

from passafe.filter import SafetyPassivityFilter
from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth, StateSet
from passafe.uncertainty import Uncertainty

THREADS, ROUNDS = 4, 60
STATES = [(0.02 * k - 0.5, 0.6 - 0.03 * k) for k in range(40)]


@pytest.fixture(autouse=True)
def switching() -> Iterator[None]:
    """Have the interpreter change threads as often as it can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def assert_same_alone_and_together(ask: Callable[[tuple[float, float]], object]) -> None:
    alone = [ask(x) for x in STATES]
    with ThreadPoolExecutor(THREADS) as pool:
        together = list(pool.map(ask, STATES * ROUNDS))
    assert together == alone * ROUNDS


def test_a_decision_is_that_of_its_own_request() -> None:
    core = SafetyPassivityFilter(cart())

    assert_same_alone_and_together(lambda x: core.decide(x, (0.0,), (30.0,), (0.0,)).u)


def test_a_step_is_that_of_its_own_state() -> None:
    plant = SampledPlant(CART, X[1] ** 2 / 2, 0.01)

    assert_same_alone_and_together(lambda x: plant.advance(x, (3.0,)))


def test_an_error_is_that_of_its_own_state() -> None:
    growth = ErrorGrowth(cart(uncertainty=Uncertainty(disturbance=(0.0, 1.0))))

    assert_same_alone_and_together(lambda x: growth.advance(x, (1.0,), (0.0, abs(x[0]))))
    assert_same_alone_and_together(lambda x: growth.roll(StateSet(center=x, radius=(0.0, 0.1)), [(1.0,)] * 9))
