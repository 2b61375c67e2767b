"""Margins of the loop of person and robot, against the loop's frequency response."""

from cmath import exp, phase
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.operator.human.crossover import CrossoverLoop


def loop_of(omega: float = 2.0, reaction_s: float = 0.2, lag_s: float = 0.1, glance_s: float = 0.02) -> CrossoverLoop:
    return CrossoverLoop(crossover_rad_per_s=omega, reaction_s=reaction_s, neuromuscular_s=lag_s, glance_s=glance_s)


def response(loop: CrossoverLoop, omega: float, extra_s: float = 0.0) -> complex:
    s = 1j * omega
    delay_s = loop.reaction_s + loop.glance_s / 2 + extra_s
    return loop.crossover_rad_per_s * exp(-delay_s * s) / (s * (loop.neuromuscular_s * s + 1))


def test_margins_without_lag_are_those_of_the_crossover_model() -> None:
    """π/2 − ω_c τ, and π/(2ω_c) − τ of delay (McRuer & Jex 1967)."""
    loop = loop_of(3.0, 0.25, 1e-9, 0.0)

    assert loop.unit_gain_rad_per_s == pytest.approx(3.0)
    assert loop.phase_margin_rad == pytest.approx(pi / 2 - 0.75)
    assert loop.delay_margin_s == pytest.approx(pi / 6 - 0.25)


@given(st.floats(0.1, 10), st.floats(0.02, 2), st.floats(0.01, 1), st.floats(0.005, 0.25))
def test_at_the_margins_the_loop_is_minus_one(omega: float, reaction_s: float, lag_s: float, glance_s: float) -> None:
    loop = loop_of(omega, reaction_s, lag_s, glance_s)
    at = response(loop, loop.unit_gain_rad_per_s)

    assert abs(at) == pytest.approx(1.0, rel=1e-12)
    assert phase(-at * exp(-1j * loop.phase_margin_rad)) == pytest.approx(0.0, abs=1e-9)
    assert response(loop, loop.unit_gain_rad_per_s, loop.delay_margin_s) == pytest.approx(-1.0, abs=1e-9)


def test_the_defaults_leave_a_margin_as_people_have_it() -> None:
    loop = loop_of()

    assert loop.effective_delay_s == pytest.approx(0.31)
    assert loop.phase_margin_rad == pytest.approx(0.9649, abs=1e-4)
    assert loop.delay_margin_s == pytest.approx(0.4916, abs=1e-4)
