from math import inf

import pytest
from closed_form import MS, h, paper_scenario, position, state, tick
from hypothesis import given
from hypothesis import strategies as st

from dashboard.columns import (
    Layout,
    drawn_columns,
    signed_log,
    signed_log_inverse,
)
from protocol.messages import BarrierChain

LAYOUT = Layout.of(paper_scenario())


def test_a_barrier_has_as_many_psi_as_class_k_functions() -> None:
    assert LAYOUT.levels == (3,)
    assert LAYOUT.chain == ((0, 0), (0, 1), (0, 2))
    assert LAYOUT.names == ("disk",)
    assert LAYOUT.h_unit == "m²"
    assert LAYOUT.log_columns == ("psi_0_1", "psi_0_2")


def test_values_of_a_tick_stand_under_their_columns() -> None:
    values = LAYOUT.tick_values(tick(500, slack=0.25, state_age_ns=3 * MS, command_age_ns=7 * MS))
    assert values is not None
    named = dict(zip(LAYOUT.tick_columns, values, strict=True))
    assert named["status"] == 2
    assert named["slack_w"] == 0.25
    assert named["state_age_ms"] == pytest.approx(3.0)
    assert named["command_age_ms"] == pytest.approx(7.0)
    assert named["psi_0_0"] == h(0.5)
    assert named["psi_0_2"] == 100 * h(0.5)


def test_values_of_a_state_stand_under_their_columns() -> None:
    values = LAYOUT.state_values(state(500))
    assert values is not None
    named = dict(zip(LAYOUT.state_columns, values, strict=True))
    assert (named["p1_m"], named["p2_m"]) == position(0.5)
    assert named["h_0"] == pytest.approx(h(0.5))


@pytest.mark.parametrize(
    "barriers", [(), (BarrierChain("disk", (1.0, 2.0)),), (BarrierChain("disk", (1.0, 2.0, 3.0)),) * 2]
)
def test_a_tick_of_another_scenario_has_no_values(barriers: tuple[BarrierChain, ...]) -> None:
    assert LAYOUT.tick_values(tick(0, barriers=barriers)) is None


def test_a_state_without_a_plane_has_no_values() -> None:
    assert LAYOUT.state_values(state(0, x=(1.0,))) is None


def test_drawn_columns_add_time_zero_line_and_signed_logarithms() -> None:
    assert drawn_columns(("a", "b"), ("b",)) == ("start_s", "time_s", "zero", "a", "b", "b_log")


@given(st.floats(-1e8, 1e8), st.floats(-1e8, 1e8))
def test_signed_log_is_odd_increasing_and_invertible(a: float, b: float) -> None:
    assert signed_log(-a) == -signed_log(a)
    assert signed_log_inverse(signed_log(a)) == pytest.approx(a, rel=1e-9, abs=1e-12)
    if a < b:
        assert signed_log(a) <= signed_log(b)


def test_signed_log_has_zero_at_zero_and_takes_anything() -> None:
    assert signed_log(0.0) == 0.0
    assert signed_log(inf) == inf
