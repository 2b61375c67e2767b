"""Chains of barriers with kinks: one for each part of a minimum, of a maximum the branch that holds best."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import gains, paper_design
from finite_differences import numeric

from passafe.barrier_chain import Barrier, derive_chain, derive_chains
from passafe.class_k import Piecewise
from passafe.decision import Decision
from passafe.design import Mode
from passafe.errors import DesignError, RelativeDegreeError
from passafe.filter import SafetyPassivityFilter
from passafe.system import System

x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
PLANE = System(x=x, u=u, f=ca.vertcat(x[2:], u - x[2:]), y=x[2:])
LEFT, RIGHT = 1 - ca.sumsqr(x[:2] + ca.DM([0.5, 0])), 1 - ca.sumsqr(x[:2] - ca.DM([0.5, 0]))


def barrier(h: ca.SX, *, degree: int = 2) -> Barrier:
    return Barrier(name="room", h=h, class_k=gains(*(3.0 for _ in range(degree + 1))))


def test_a_minimum_has_a_chain_for_each_part() -> None:
    chains = derive_chains(PLANE, barrier(1 - ca.norm_inf(x[:2])))
    psi = numeric([x], ca.vertcat(*(chain.psi[0] for chain in chains)))

    assert [chain.barrier.name for chain in chains] == ["room[1]", "room[2]", "room[3]", "room[4]"]
    assert all(chain.relative_degree == 2 and chain.branches == (chain,) for chain in chains)
    assert psi([0.2, -0.3, 0, 0]) == pytest.approx([0.8, 1.2, 1.3, 0.7])


def test_parts_share_their_gains_as_far_as_they_need_them() -> None:
    place, speed = derive_chains(PLANE, barrier(ca.fmin(1 - x[0], 1 - x[2])))

    assert (place.relative_degree, speed.relative_degree) == (2, 1)
    assert speed.barrier.class_k == place.barrier.class_k[:2]


def test_a_smooth_barrier_has_its_own_chain_alone() -> None:
    one = barrier(LEFT)
    (chain,) = derive_chains(PLANE, one)

    assert chain.barrier is one
    assert chain.psi[0] is one.h
    assert chain.chosen([ca.SX(7)]) == 7


def test_one_chain_is_asked_of_one_part() -> None:
    assert derive_chain(PLANE, barrier(LEFT)).relative_degree == 2
    with pytest.raises(DesignError, match=r"barrier 'room' h: got 2 parts, allowed one; derive_chains derives all"):
        derive_chain(PLANE, barrier(1 - ca.fabs(x[0])))


def test_a_maximum_is_the_branch_that_holds_best() -> None:
    (chain,) = derive_chains(PLANE, barrier(ca.fmax(LEFT, RIGHT)))
    left, right = chain.branches
    seen, of_left, of_right = (numeric([x, u], ca.vertcat(*one.psi)) for one in (chain, left, right))
    which = numeric([x], chain.chosen([ca.SX(1), ca.SX(2)]))
    rng = np.random.default_rng(12)
    taken = set()
    for at, held in zip(rng.normal(size=(60, 4)), rng.normal(size=(60, 2)), strict=True):
        options = [of_left(at, held), of_right(at, held)]
        better = int(options[1][:2].min() > options[0][:2].min())
        taken.add(better)
        assert which(at)[0] == better + 1
        assert seen(at, held) == pytest.approx(options[better])
    assert taken == {0, 1}
    assert numeric([x], chain.barrier.h)([0.5, 0, 0, 0]) == pytest.approx([1.0])


def test_branches_need_one_relative_degree() -> None:
    with pytest.raises(DesignError, match=r"'room' h: got a maximum of branches of relative degrees \[2, 1\]"):
        derive_chains(PLANE, barrier(ca.fmax(1 - x[0], 1 - x[2])))


@pytest.mark.parametrize("given", [2, 4])
def test_branches_need_a_function_for_each_derivative(given: int) -> None:
    with pytest.raises(DesignError, match=rf"'room' class_k: got {given} functions, allowed 3: relative degree 2"):
        derive_chains(PLANE, barrier(ca.fmax(LEFT, RIGHT), degree=given - 1))


def test_parts_that_are_numbers_are_left_out() -> None:
    (clipped,) = derive_chains(PLANE, barrier(ca.fmin(LEFT, 5)))
    (floored,) = derive_chains(PLANE, barrier(ca.fmax(LEFT, -5)))

    assert clipped.barrier.name == floored.barrier.name == "room"
    assert len(clipped.branches) == len(floored.branches) == 1
    with pytest.raises(DesignError, match="which is never negative, allowed a function that is negative somewhere"):
        derive_chains(PLANE, barrier(ca.fmax(LEFT, 5)))
    with pytest.raises(DesignError, match="a part that is -2 everywhere, allowed a function that is positive"):
        derive_chains(PLANE, barrier(ca.fmin(LEFT, -2)))
    with pytest.raises(RelativeDegreeError):
        derive_chains(PLANE, barrier(ca.SX(3.0)))


def test_kinks_of_the_dynamics_are_allowed_where_the_input_comes() -> None:
    drag = System(x=x, u=u, f=ca.vertcat(x[2:], ca.fmin(u, 5) - x[2:] * ca.fabs(x[2:])), y=x[2:])
    assert derive_chain(drag, barrier(LEFT)).relative_degree == 2
    bent = System(x=x, u=u, f=ca.vertcat(ca.fmin(x[2:], 1), u), y=x[2:])
    with pytest.raises(
        DesignError, match=r"barrier 'room': got .*x_2.* of the dynamics in derivative 1 of h, which has"
    ):
        derive_chain(bent, barrier(x[0] + 2))


def test_piecewise_gains_are_allowed_anywhere_in_the_chain() -> None:
    one = replace(barrier(LEFT), class_k=gains(Piecewise(gain=2.0, gain_below=5.0), 3.0, 3.0))

    assert derive_chain(PLANE, one).relative_degree == 2


def filter_of(h: ca.SX) -> SafetyPassivityFilter:
    """Return a filter of the paper's robot for one barrier of its state, which is ``x``."""
    design = paper_design(mode=Mode.SAFE, u_fb=ca.SX.zeros(2), k_i=50.0)
    moved = ca.substitute(h, x, design.system.x)
    return SafetyPassivityFilter(replace(design, barriers=(barrier(moved),)))


def driven(made: SafetyPassivityFilter, h: ca.SX, start: list[float], push: tuple[float, float]) -> tuple[float, float]:
    """Return the lowest h of 1.5 s, and the share of decisions that were fallbacks."""
    flow, level = numeric([made.design.system.x, made.design.system.u], made.design.system.f), numeric([x], h)
    at, held, lowest, fallbacks = np.array(start), (0.0, 0.0), np.inf, 0
    for _ in range(1500):
        decision: Decision = made.decide(at.tolist(), held, push, (0.0, 0.0))
        held, fallbacks = decision.u, fallbacks + decision.status.is_fallback
        middle = at + 5e-4 * flow(at, np.array(held))
        at = at + 1e-3 * flow(middle, np.array(held))
        lowest = min(lowest, float(level(at)[0]))
    return lowest, fallbacks / 1500


@pytest.mark.parametrize(
    "h",
    [
        ca.fmin(ca.sumsqr(x[:2] - ca.DM([1.3, 0.2])) - 0.3, ca.sumsqr(x[:2] - ca.DM([1.3, -0.7])) - 0.25),
        0.8 - ca.norm_1(x[:2]),
        1 - ca.logsumexp(6 * ca.vertcat(x[0], x[1], -x[0], -x[1])) / 6,
        0.7 - ca.norm_2(x[:2]),
        0.6 - ca.sqrt(ca.sumsqr(x[:2]) + 1e-6),
    ],
)
@pytest.mark.parametrize("start", [[0.0, 0.0, 0.0, 0.0], [1e-5, 0.0, 0.02, -0.01]])
def test_driven_at_a_kink_or_from_a_singular_point(h: ca.SX, start: list[float]) -> None:
    lowest, fallbacks = driven(filter_of(h), h, start, (6.0, -0.4))

    assert lowest >= -1e-9
    assert lowest < 0.2
    assert fallbacks == 0


def test_at_the_centre_of_an_obstacle_s_norm_there_is_an_answer() -> None:
    decision = filter_of(ca.norm_2(x[:2]) - 0.5).decide([0.0] * 4, (0.0, 0.0), (1.0, 0.0), (0.0, 0.0))

    assert np.isfinite(decision.u).all()
    assert np.isfinite(decision.part("psi")).all()
