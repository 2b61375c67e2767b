"""Designs with operations that jump: refused with the part, the operation, the reason, and what to write instead."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import pytest
from core_designs import gains, paper_design

from passafe.barrier_chain import Barrier
from passafe.enclosures.jumps import require_no_jumps
from passafe.errors import DesignError
from passafe.system import System

PAPER = paper_design()
x, u, t = PAPER.system.x, PAPER.system.u, PAPER.system.t
TABLE = ca.interpolant("drag_table", "linear", [[-2.0, 0.0, 2.0]], [1.5, 0.0, 1.5])


@pytest.mark.parametrize(
    ("h", "shown", "why", "instead"),
    [
        (3 - ca.floor(x[0]), r"floor in floor\(x_0\)", "rounding, which jumps", "one barrier for each step"),
        (ca.ceil(2 * x[1]) - x[0], r"ceil in ceil\(\(2\.\*x_1\)\)", "rounding, which jumps", "one barrier for each"),
        (ca.sign(ca.cos(2 * t)) - x[0], r"sign in sign\(cos\(\(2\.\*t\)\)\)", "a sign, which jumps at zero", "tanh"),
        (ca.if_else(t > 2, 3, 1) - x[0], r"if_else in .*\(2<t\)", "a choice by a condition", "several barriers"),
        (ca.fmod(x[0], 0.7) - x[1], r"fmod in fmod\(x_0,0\.7\)", "a remainder, which jumps", "sin and cos"),
        (ca.remainder(x[0], x[1]), r"remainder in", "a remainder, which jumps", "sin and cos"),
        (2 - x[0] * (x[1] > 0), r"lt in \(0<x_1\)", "a choice by a condition", r"\(1 \+ tanh\(k\*v\)\)/2"),
        (ca.logic_or(x[0] < 1, x[1] < 1) - 0.5, r"or in", "a choice by a condition", "several barriers"),
        (ca.copysign(x[0], x[1]) + 2, r"copysign in", "a sign, which jumps at zero", "tanh"),
        (5 - TABLE(x[0]), r"call in function\(x_0\)", "a look-up table", "a polynomial or a sum of tanh"),
        (ca.pw_lin(x[0], [0, 1, 2], [0, 1, 4]), "le in", "a choice by a condition", "fmin and fmax"),
    ],
)
def test_a_barrier_that_jumps_is_refused_with_a_way_out(h: ca.SX, shown: str, why: str, instead: str) -> None:
    with pytest.raises(DesignError, match=f"barrier 'odd' h: got {shown}.*{why}.*allowed continuous.*{instead}"):
        replace(PAPER, barriers=(Barrier(name="odd", h=h, class_k=gains(1.0, 1.0, 1.0)),))


@pytest.mark.parametrize(
    ("part", "change"),
    [
        ("dynamics f", lambda jump: {"system": System(x=x, u=u, f=PAPER.system.f + jump, y=PAPER.system.y)}),
        ("output y", lambda jump: {"system": System(x=x, u=u, f=PAPER.system.f, y=PAPER.system.y + jump)}),
        ("feedback u_fb", lambda jump: {"u_fb": PAPER.u_fb + jump}),
        ("storage V", lambda jump: {"passivity": replace(PAPER.passivity, V=PAPER.passivity.V + jump)}),
    ],
)
@pytest.mark.parametrize(("jump", "name"), [(ca.sign(x[2]), "sign"), (TABLE(x[3]), "look-up table")])
def test_every_part_that_is_differentiated_is_named(
    part: str, change: Callable[[ca.SX], dict[str, object]], jump: ca.SX, name: str
) -> None:
    with pytest.raises(DesignError, match=f"^{part}: got .*{name}"):
        replace(PAPER, barriers=(), **change(jump))


def test_a_fail_safe_law_may_jump() -> None:
    law = -ca.sign(PAPER.system.x[2:])

    assert replace(PAPER, fail_safe=law).fail_safe is law


def test_kinks_and_slopes_of_every_kind_are_allowed() -> None:
    a, b = x[0], x[2]
    smooth = ca.tan(a) + ca.asin(b) + ca.erf(a) + ca.hypot(a, b) + a**2.5 + ca.log1p(b) + ca.atan2(a, b)
    require_no_jumps("h", ca.vertcat(smooth, ca.fmin(a, 2) * ca.fabs(b), ca.fmax(a, b), ca.copysign(a, -1.0)))


def test_an_operation_of_no_kind_is_refused_all_the_same() -> None:
    with pytest.raises(
        DesignError, match=r"printme in .*an operation without a derivative.*write elementary functions"
    ):
        require_no_jumps("h", ca.SX.binary(ca.OP_PRINTME, x[0], x[1]))


def test_a_long_expression_is_cut_in_the_message() -> None:
    long = sum((x[0] ** k * ca.sin(k * x[1]) for k in range(2, 9)), ca.SX(0))
    with pytest.raises(DesignError) as refusal:
        require_no_jumps("h", ca.sign(long))

    assert "…, a sign" in str(refusal.value)
    assert len(str(refusal.value)) < 250
