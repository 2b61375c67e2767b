"""The margin between samples: the bound it rests on, and what it gives on trajectories that the model really takes."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, drag_design, gains, paper_design, pump_design, random_state
from finite_differences import numeric, runge_kutta

import passafe.filter
from passafe.barrier_chain import Barrier, derive_chain
from passafe.class_k import Cubic, Piecewise
from passafe.decision import Decision, Status
from passafe.design import Mode
from passafe.errors import DesignError
from passafe.filter import SafetyPassivityFilter
from passafe.intersample_margin import UNKNOWN, curvature_bound, held_function
from passafe.system import System

PARTS = 8


@pytest.mark.parametrize("build", DESIGNS)
def test_no_trajectory_bends_down_more_than_the_bound(build: Builder) -> None:
    """p(τ) ≥ p(0) + τ ṗ(0) − ½τ²M all over a period, for every input in the box around u."""
    design = build()
    system, dt_s = design.system, design.dt_s
    flow = numeric([system.x, system.u], system.f)
    rng = np.random.default_rng(80)
    radius = np.full(system.m, 0.3)
    for barrier in design.barriers:
        chain = derive_chain(system, barrier)
        r = chain.relative_degree
        p = chain.psi[r - 1]
        bound = numeric([system.x, system.u], curvature_bound(system, p, dt_s, ca.SX(radius), steps=max(r, 2)))
        value = numeric([system.x], p)
        rate = numeric([system.x, system.u], system.rate(p))
        for _ in range(25):
            x, u = random_state(rng, system.n), random_state(rng, system.m)
            M = float(bound(x, u)[0])
            held = u + rng.uniform(-1, 1, system.m) * radius
            s = x
            assert M < 1e6  # the tube was found
            for k in range(1, PARTS + 1):
                s = runge_kutta(lambda _, s, held=held: flow(s, held), 0.0, s, dt_s / PARTS)  # type: ignore[misc]  # bound
                tau = k * dt_s / PARTS
                straight = value(x)[0] + tau * rate(x, held)[0]

                assert value(s)[0] >= straight - tau**2 / 2 * M - 1e-10 * (1 + abs(straight))


def test_bound_is_huge_where_a_state_may_leave_its_tube() -> None:
    """ẋ₂ = 2000·x₂ grows further within 1 ms than is guessed; that another state keeps to its tube changes nothing."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(u, 2000 * x[1]), y=x[0])
    bound = numeric([x, u], curvature_bound(system, x[0] ** 2, 1e-3, ca.SX(0), steps=2))

    assert bound([1.0, 0.1], [3.0])[0] == UNKNOWN
    assert bound([1.0, 0.0], [3.0])[0] == pytest.approx(-2 * 3.0**2)  # −p̈ = −2u²


def test_a_moving_set_s_bend_is_in_the_bound() -> None:
    """An obstacle that turns around at full stop bends p although the robot rests: p̈ = −2·a·‖x₁ − c‖ there."""
    design = paper_design()
    system = design.system
    centre = ca.vertcat(ca.sin(20 * system.t), 0)
    p = ca.sumsqr(system.x[:2] - centre) - 0.25
    bound = numeric([system.x, system.u, system.t], curvature_bound(system, p, 1e-3, ca.SX.zeros(2), steps=2))
    at = np.pi / 40  # c = (1, 0), at rest

    assert bound([3, 0, 0, 0], [0, 0], at)[0] == pytest.approx(-(2 * (3 - 1) * 400), rel=0.1)
    assert bound([-1, 0, 0, 0], [0, 0], at)[0] == pytest.approx(2 * 2 * 400, rel=0.1)


@pytest.mark.parametrize(("gamma", "steep"), [(Cubic(gain=100.0), True), (Piecewise(gain=1.0, gain_below=9.0), False)])
def test_sampled_input_may_use_one_period_of_the_margin_only(gamma: Cubic, steep: bool) -> None:
    design = paper_design()
    system = design.system
    disk = replace(design.barriers[0], class_k=gains(10.0, gamma, 1.0))
    chain = derive_chain(system, disk)
    held = numeric([system.x, system.u], held_function(system, chain, 1e-3))
    plain = numeric([system.x, system.u], chain.psi[2])
    rest = numeric([system.x, system.u], system.rate(chain.psi[1]))
    far, near, u = [3, 0, 1, 0], [1.01, 0, 0, 0], [1, 2]
    p = numeric([system.x], chain.psi[1])(far)[0]

    assert held(near, u) == pytest.approx(plain(near, u))
    assert held(far, u) == pytest.approx(rest(far, u) + p / 1e-3 if steep else plain(far, u))


def test_a_linear_gain_that_a_period_can_use_is_left_alone() -> None:
    design = paper_design()
    chain = derive_chain(design.system, design.barriers[0])

    assert held_function(design.system, chain, 1e-3) is chain.psi[2]
    assert held_function(design.system, chain, 0.2) is not chain.psi[2]


def speed_limit(margin: bool, dt_s: float = 0.02, hold_s: float | None = None) -> SafetyPassivityFilter:
    """Return a filter that keeps the paper's robot below 2 m/s: relative degree 1, p bends with ‖u‖²."""
    design = paper_design(mode=Mode.SAFE, dt_s=dt_s, k_i=20.0, input_bound=30.0, between_samples=margin)
    design = replace(design, hold_s=hold_s)
    limit = Barrier(name="speed", h=4 - ca.sumsqr(design.system.x[2:]), class_k=gains(10.0, 10.0))
    return SafetyPassivityFilter(replace(design, barriers=(limit,)))


@pytest.mark.parametrize("margin", [True, False])
def test_speed_limit_holds_between_samples_only_with_margin(margin: bool) -> None:
    """50 Hz, an operator who turns the push around again and again."""
    made = speed_limit(margin)
    system = made.design.system
    flow = numeric([system.x, system.u], system.f)
    x, u, lowest = np.array([3.0, 0.0, 0.0, 0.0]), (0.0, 0.0), np.inf
    for k in range(150):
        push = (40.0 * (-1) ** (k // 15), 25.0 * (-1) ** (k // 23))
        decision = made.decide(x.tolist(), u, push, (0.0, 0.0))
        u = decision.u
        assert decision.status in {Status.PASSED, Status.MODIFIED}
        for _ in range(PARTS):
            x = runge_kutta(lambda _, s, u=u: flow(s, np.array(u)), 0.0, x, made.design.dt_s / PARTS)  # type: ignore[misc]
            lowest = min(lowest, 4 - float(x[2:] @ x[2:]))
    assert (lowest >= 0.0) == margin
    assert lowest > -1.0


def test_accepted_answer_has_the_margin_of_its_neighbourhood() -> None:
    """Not affine in u, bent hard, large steps: nearly all find theirs, the others are not used."""
    made = SafetyPassivityFilter(pump_design())
    value = numeric([made.design.system.x], made.chains[0].psi[0])
    rng = np.random.default_rng(81)
    refused = used = 0
    while used < 600:
        x, u, u_h = random_state(rng, 2), random_state(rng, 2), 6 * random_state(rng, 2)
        if value(x)[0] < 0:
            continue
        decision = made.decide(list(x), list(u), list(u_h), [0.0, 0.0], 1.0)
        refused += decision.status.is_fallback
        if not decision.status.is_fallback:
            used += 1
            assert decision.part("shortfall")[0] <= 0
            assert decision.part("outside_trust_region")[0] <= 0
            assert np.abs(decision.u - decision.part("u_lin")).max() <= decision.part("trust").max() + 1e-12
    assert refused < 6


def test_outside_the_set_the_margin_is_given_up() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE))
    inside, outside = (made.decide((x, 0.0, 0.0, 0.0), (0.0, 0.0), (-50.0, 0.0), (0.0, 0.0)) for x in (1.001, 0.9))

    assert inside.part("eps")[0] > 0
    assert outside.part("eps")[0] == 0


def second_answers(made: SafetyPassivityFilter) -> Iterator[Decision]:
    """Give decisions that took a second answer, with tangents and margins about the first."""
    rng = np.random.default_rng(84)
    while True:
        x, u = random_state(rng, 4), random_state(rng, 2)
        decision = made.decide(list(x), list(u), list(50 * random_state(rng, 2)), (0.0, 0.0))
        if decision.status is Status.MODIFIED and (decision.part("u_lin") != u).all():
            yield decision


def test_second_margin_covers_half_the_step_to_the_first_answer() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE))
    for decision in islice(second_answers(made), 20):
        way = np.abs(decision.part("u_lin") - decision.part("u"))
        assert way.max() > 1.01 * way.min()
        assert decision.part("trust") == pytest.approx([way.max() / 2 + 0.1] * 2, rel=1e-12)


def test_the_last_margin_is_for_every_input(monkeypatch: pytest.MonkeyPatch) -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE))
    monkeypatch.setattr(passafe.filter, "ATTEMPTS", 1)
    decision = next(second_answers(made))

    assert decision.part("trust") == pytest.approx([made.design.limits.reach] * 2)


def test_conflicting_margin_is_retried_for_a_tenth_of_the_radius() -> None:
    """Drag, 20 ms: the margin for all the way to û leaves no input, that for a tenth of it does."""
    made = SafetyPassivityFilter(drag_design(dt_s=0.02, k_i=40.0))
    decision = made.decide((0.4456, 0.4684, 0.8762, 0.2565), (-0.474, -1.294), (52.8, -112.5), (0.0, 0.0))
    way = np.abs(decision.part("u_ref") - decision.part("u")).max()

    assert decision.status is Status.MODIFIED
    assert decision.part("u_lin") == pytest.approx([-0.474, -1.294])
    assert decision.part("trust") == pytest.approx([(way + 0.05) / 10] * 2)


def test_a_margin_that_does_not_settle_is_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    made = speed_limit(margin=True)
    request = ([3.0, 0.0, 1.99, 0.0], (-25.0, 20.0), (90.0, 0.0), (0.0, 0.0))
    assert made.decide(*request).status is Status.MODIFIED
    monkeypatch.setattr(passafe.filter, "ATTEMPTS", 1)
    monkeypatch.setattr(made.design.limits.__class__, "reach", 0.0)

    assert made.decide(*request).status is Status.UNCERTIFIED


@pytest.mark.parametrize("covered", [True, False])
def test_input_held_for_the_longest_time_keeps_the_barrier(covered: bool) -> None:
    """At 1 kHz every input is held for 20 ms, in thought; with a margin for one period that breaks the speed limit."""
    made = speed_limit(margin=True, dt_s=1e-3, hold_s=0.02 if covered else None)
    flow = numeric([made.design.system.x, made.design.system.u], made.design.system.f)
    x, u, lowest = np.array([3.0, 0.0, 0.0, 0.0]), (0.0, 0.0), np.inf
    for k in range(600):
        push = (60.0 * np.cos(0.01 * k), 60.0 * np.sin(0.01 * k))
        decision = made.decide(x.tolist(), u, push, (0.0, 0.0))
        u, held = decision.u, x
        assert not decision.status.is_fallback
        for part in range(20):
            held = runge_kutta(lambda _, s, u=u: flow(s, np.array(u)), 0.0, held, 1e-3)  # type: ignore[misc]  # bound
            lowest = min(lowest, 4 - float(held[2:] @ held[2:]))
            x = held if part == 0 else x

    assert (lowest >= 0.0) == covered
    assert lowest > -1.0


def test_what_is_held_is_at_least_a_period() -> None:
    assert paper_design(hold_s=0.0).held_s == paper_design().held_s == 1e-3
    assert paper_design(hold_s=0.02).held_s == 0.02
    with pytest.raises(DesignError, match=r"hold_s: got -0\.1, allowed a finite number, zero or more"):
        paper_design(hold_s=-0.1)
