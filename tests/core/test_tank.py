from itertools import accumulate
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from passafe.errors import DesignError
from passafe.tank import Tank

# Multiples of 2⁻¹⁰ J of this size add up without rounding, so that the ledger can be checked exactly.
quanta = st.integers(-(2**20), 2**20).map(lambda count: count / 1024)
periods = st.lists(st.tuples(quanta, quanta), max_size=20)
tanks = st.builds(
    lambda reserve, more, room: Tank(reserve_j=reserve, initial_j=reserve + more, max_j=reserve + more + room),
    *[st.integers(0, 2**14).map(lambda count: count / 1024)] * 3,
)


def ledger(tank: Tank, flows: list[tuple[float, float]]) -> list[float]:
    return list(accumulate(flows, lambda level, flow: tank.balance(level, *flow), initial=tank.initial_j))


def test_the_least_positive_rate_is_one() -> None:
    assert Tank(rate_per_s=5e-324).rate_per_s == 5e-324


@given(tank=tanks, flows=periods)
def test_never_above_its_ceiling(tank: Tank, flows: list[tuple[float, float]]) -> None:
    assert max(ledger(tank, flows)) <= tank.max_j


@given(tank=tanks, flows=periods)
def test_non_negative_level_bounds_the_energy_given_out(tank: Tank, flows: list[tuple[float, float]]) -> None:
    """E(k) ≥ 0 ⇒ V(k) − V(0) − ∫yᵀu ≤ E(0): the environment got no more than it gave, plus the first filling."""
    for k, level in enumerate(ledger(tank, flows)):
        given_out = sum(stored - supplied for supplied, stored in flows[:k])

        assert given_out <= tank.initial_j - level
        if level >= 0:
            assert given_out <= tank.initial_j


@given(tank=tanks, flows=periods)
def test_below_its_ceiling_it_is_an_exact_ledger(tank: Tank, flows: list[tuple[float, float]]) -> None:
    roomy = Tank(initial_j=tank.initial_j, reserve_j=tank.reserve_j, max_j=1e9)

    assert ledger(roomy, flows)[-1] == tank.initial_j + sum(supplied - stored for supplied, stored in flows)


def test_what_exceeds_the_ceiling_is_forgotten() -> None:
    tank = Tank(initial_j=1.0, max_j=2.0)

    assert tank.balance(1.0, 5.0, 1.0) == 2.0
    assert tank.balance(2.0, 0.0, 0.5) == 1.5
    assert tank.balance(0.25, 0.0, 1.0) == -0.75


@pytest.mark.parametrize(
    "energies",
    [
        {"reserve_j": -0.1},
        {"reserve_j": 1.5},
        {"initial_j": 11.0},
        {"max_j": 0.9},
        {"max_j": inf},
        {"reserve_j": nan},
        {"initial_j": nan},
        {"max_j": nan},
    ],
)
def test_energies_are_ordered_and_finite(energies: dict[str, float]) -> None:
    with pytest.raises(DesignError) as refused:
        Tank(**energies)

    reserve, initial, most = ({"reserve_j": 0.5, "initial_j": 1.0, "max_j": 10.0} | energies).values()
    got = f"reserve {reserve}, initial {initial}, max {most}"
    assert str(refused.value) == f"tank energies: got {got}, allowed 0 ≤ reserve ≤ initial ≤ max, finite, J"


@pytest.mark.parametrize("rate", [0.0, -1.0, inf, nan])
def test_rates_are_positive_and_finite(rate: float) -> None:
    with pytest.raises(DesignError) as refused:
        Tank(rate_per_s=rate)

    assert str(refused.value) == f"tank rate_per_s: got {rate}, allowed a positive finite number, 1/s"


@given(tank=tanks, flows=periods)
def test_many_ledgers_are_kept_as_one_is(tank: Tank, flows: list[tuple[float, float]]) -> None:
    before = np.array([tank.initial_j] * len(flows))
    supplied, stored = (np.array([flow[i] for flow in flows]) for i in range(2))
    expected = [tank.balance(tank.initial_j, *flow) for flow in flows]

    assert tank.balance_many(before, supplied, stored).tolist() == expected


def test_a_ledger_that_is_no_number_is_not_taken_for_a_full_one() -> None:
    after = Tank().balance_many(np.array([1.0, nan, 1.0]), np.array([nan, 0.0, 50.0]), np.zeros(3))

    assert np.isnan(after).tolist() == [True, True, False]
    assert after[2] == Tank().max_j
