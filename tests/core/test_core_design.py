from dataclasses import FrozenInstanceError
from math import inf, nan

import casadi as ca
import pytest
from core_designs import gains, paper_design

from passafe.barrier_chain import Barrier
from passafe.certificate import Tolerance
from passafe.design import Law, Mode
from passafe.errors import DesignError, ShapeError


@pytest.mark.parametrize(
    ("mode", "safety", "passivity"),
    [
        (Mode.OFF, False, False),
        (Mode.SAFE, True, False),
        (Mode.PASSIVE, False, True),
        (Mode.BOTH, True, True),
    ],
)
def test_what_each_mode_enforces(mode: Mode, *, safety: bool, passivity: bool) -> None:
    assert (mode.enforces_safety, mode.enforces_passivity) == (safety, passivity)


def test_laws_and_modes_have_the_values_of_files_and_messages() -> None:
    assert [law.value for law in Law] == ["sampled", "continuous"]
    assert [mode.value for mode in Mode] == ["off", "safe", "passive", "both"]


def test_defaults() -> None:
    design = paper_design()

    assert (design.law, design.mode) == (Law.SAMPLED, Mode.BOTH)
    assert design.tolerance == Tolerance(residual=1e-6, gap=1e-6)


def test_a_design_does_not_change() -> None:
    with pytest.raises(FrozenInstanceError):
        paper_design().k_i = 1.0  # type: ignore[misc]  # that it is refused is the point


@pytest.mark.parametrize("part", ["k_i", "dt_s", "input_bound"])
@pytest.mark.parametrize("value", [0.0, -1.0, inf, nan])
def test_gains_periods_and_bounds_are_positive_and_finite(part: str, value: float) -> None:
    with pytest.raises(DesignError) as refused:
        paper_design(**{part: value})

    assert str(refused.value) == f"{part}: got {value}, allowed a positive finite number"


def test_tracking_that_would_oscillate_is_refused() -> None:
    paper_design(k_i=999.0, dt_s=1e-3)
    with pytest.raises(DesignError) as refused:
        paper_design(k_i=1000.0, dt_s=1e-3)

    assert str(refused.value) == "k_i: got 1000.0, allowed less than 1/dt_s = 1000, or the tracking oscillates"


@pytest.mark.parametrize("part", ["u_fb", "fail_safe"])
def test_feedback_and_fail_safe_need_one_row_for_every_input(part: str) -> None:
    with pytest.raises(ShapeError, match=rf"{part}: got shape \(1, 1\), allowed shape \(2, 1\)"):
        paper_design(**{part: ca.SX(0.0)})
    with pytest.raises(DesignError, match=rf"{part}: got the symbols \['wind'\]"):
        paper_design(**{part: ca.vertcat(ca.SX.sym("wind"), 0)})


def test_each_barrier_has_a_name_of_its_own() -> None:
    one = Barrier(name="wall", h=ca.SX(1.0), class_k=gains(1.0))
    other = Barrier(name="disk", h=ca.SX(1.0), class_k=gains(1.0))

    assert len(paper_design(barriers=(one, other)).barriers) == 2
    with pytest.raises(DesignError) as refused:
        paper_design(barriers=(one, other, one))

    assert str(refused.value) == "barriers: got the names ['wall', 'disk', 'wall'], allowed each name once"
