"""Feedback and fail-safe law in every form in which people write them, and the typed errors for all others."""

import casadi as ca
import numpy as np
import pytest
from cart_designs import X, cart, decided
from core_designs import paper_design

from passafe.design import FilterDesign
from passafe.errors import DesignError, ShapeError
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity


@pytest.mark.parametrize("part", ["u_fb", "fail_safe"])
@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_law_with_a_constant_that_is_no_number_is_refused(part: str, number: float) -> None:
    with pytest.raises(DesignError, match=f"{part}: got the number {number}, allowed finite numbers"):
        cart(**{part: ca.SX(number)})


@pytest.mark.parametrize("law", [0.5, [0.5], ca.DM(0.5), np.array([0.5]), np.float32(0.5), [ca.SX(0.5)], (ca.DM(0.5),)])
@pytest.mark.parametrize("part", ["u_fb", "fail_safe"])
def test_laws_may_be_numbers_and_sequences(part: str, law: object) -> None:
    assert decided(cart(**{part: law})) == decided(cart(**{part: ca.SX(0.5)}))


def test_a_law_may_mix_numbers_and_expressions() -> None:
    robot = damped_point()
    mixed = FilterDesign(
        system=robot.system,
        u_fb=[-robot.position[0], 2.0],  # type: ignore[arg-type]  # a sequence
        barriers=(),
        passivity=Passivity(V=ca.sumsqr(robot.velocity)),
        k_i=9.0,
        dt_s=0.1,
        input_bound=1.0,
    )

    assert str(mixed.u_fb) == "[(-x_0), 2]"
    assert str(cart(u_fb=np.array([-X[1]], dtype=object)).u_fb) == "(-x_1)"


def test_without_laws_there_is_no_feedback_and_no_input() -> None:
    assert decided(cart()) == decided(cart(u_fb=0.0, fail_safe=[0.0]))
    two = paper_design()
    bare = FilterDesign(system=two.system, barriers=(), passivity=Passivity(V=0.0), k_i=9.0, dt_s=0.1, input_bound=1.0)  # type: ignore[arg-type]  # V as a number
    assert bare.u_fb.shape == bare.fail_safe.shape == (2, 1)
    assert bare.u_fb.is_zero()
    assert bare.fail_safe.is_zero()


@pytest.mark.parametrize("part", ["u_fb", "fail_safe"])
@pytest.mark.parametrize("law", [None, "brake", lambda x: -x, b"", [None], ["a"], object(), 1j, np.array([1j])])
def test_a_law_that_is_no_expression_is_refused(part: str, law: object) -> None:
    with pytest.raises(DesignError, match=f"^{part}: got .*, allowed a casadi.SX expression, numbers"):
        cart(**{part: law})


def test_a_law_needs_one_row_for_every_input() -> None:
    with pytest.raises(ShapeError, match=r"u_fb: got shape \(1, 1\), allowed shape \(2, 1\)"):
        paper_design(u_fb=0.0)
    with pytest.raises(ShapeError, match=r"fail_safe: got shape \(3, 1\)"):
        paper_design(fail_safe=[0.0, 0.0, 0.0])
