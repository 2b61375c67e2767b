"""The margin between samples: the bound it rests on, and what it gives on trajectories that the model really takes."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, gains, paper_design, pump_design, random_state
from finite_differences import numeric, runge_kutta

import passafe.answers.attempts
from passafe.barrier_chain import Barrier, derive_chain
from passafe.class_k import Cubic, Piecewise
from passafe.decision import Decision, Status
from passafe.design import Mode
from passafe.enclosures.reachable_tube import reachable_tube
from passafe.errors import DesignError
from passafe.filter import SafetyPassivityFilter
from passafe.margins.intersample_margin import held_row
from passafe.system import System

PARTS = 8


@pytest.mark.parametrize("build", DESIGNS)
def test_no_trajectory_falls_below_what_the_deviation_leaves(build: Builder) -> None:
    """p(τ) ≥ p + φ₁(τ)q + φ₂(τ)(b − V) all over a period, for every input in the box around u."""
    design = build()
    system, dt_s = design.system, design.dt_s
    flow = numeric([system.x, system.u], system.f)
    rng = np.random.default_rng(80)
    radius = np.full(system.m, 0.3)
    tube = reachable_tube(system, dt_s, ca.SX(radius))
    for barrier in design.barriers:
        chain = derive_chain(system, barrier)
        p, row = chain.psi[chain.relative_degree - 1], held_row(system, chain, dt_s)
        size, known = row.deviation(system, tube, dt_s, ca.SX(radius))
        deviation = numeric([system.x, system.u], ca.vertcat(size, known))
        value = numeric([system.x], p)
        rate, bend = (numeric([system.x, system.u], each) for each in (system.rate(p), row.bend))
        for _ in range(25):
            x, u = random_state(rng, system.n), random_state(rng, system.m)
            V, is_known = deviation(x, u)
            held = u + rng.uniform(-1, 1, system.m) * radius
            s = x
            assert is_known == 1
            assert row.usable_s == dt_s  # λ = 0
            for k in range(1, PARTS + 1):
                s = runge_kutta(lambda _, s, held=held: flow(s, held), 0.0, s, dt_s / PARTS)  # type: ignore[misc]  # bound
                tau = k * dt_s / PARTS
                straight = value(x)[0] + tau * rate(x, held)[0]

                assert value(s)[0] >= straight + tau**2 / dt_s * (bend(x, held)[0] - V) - 1e-10 * (1 + abs(straight))


@pytest.mark.parametrize("lag_s", [5e-3, 0.02, 0.05])
def test_a_lagged_drive_is_bounded_with_its_own_decay(lag_s: float) -> None:
    """ẋ = v, v̇ = a, ȧ = (u − a)/lag, T = 10 ms: p̈ is about u/lag², of which e^{−T/lag} is left at the end."""
    x, u, held_s = ca.SX.sym("x", 3), ca.SX.sym("u"), 0.01
    system = System(x=x, u=u, f=ca.vertcat(x[1], x[2], (u - x[2]) / lag_s), y=x[1])
    row = held_row(system, derive_chain(system, Barrier(name="wall", h=1 - x[0], class_k=gains(4, 4, 4, 4))), held_s)
    decay = 1 / lag_s - 8  # −(∂q̇/∂u)/(∂q/∂u) with q = ψ̇₂
    bend = numeric([x, u], row.bend)

    assert row.usable_s == pytest.approx((1 - np.exp(-decay * held_s)) / decay)
    assert bend([0.0, 0.0, 0.0], [7.0])[0] == pytest.approx(0.0, abs=1e-9)


def test_a_deviation_is_unknown_where_no_tube_is() -> None:
    """ẋ = x² ends in finite time: from x = 200 within 5 ms, from x = 1 it does not."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    system = System(x=x, u=u, f=x**2 + u, y=x)
    row = held_row(system, derive_chain(system, Barrier(name="b", h=1 - x, class_k=gains(1, 1))), 0.01)
    tube = reachable_tube(system, 0.01, ca.SX(0))
    known = numeric([x, u], row.deviation(system, tube, 0.01, ca.SX(0)).known)

    assert known([1.0], [0.0])[0] == 1
    assert known([200.0], [0.0])[0] == 0


def test_a_moving_set_s_bend_is_exact() -> None:
    """An obstacle that turns around at full stop bends p although the robot rests: p̈ = −2·a·‖x₁ − c‖ there."""
    design = paper_design()
    system = design.system
    centre = ca.vertcat(ca.sin(20 * system.t), 0)
    speed_like = Barrier(name="b", h=ca.sumsqr(system.x[2:]) - ca.sumsqr(system.x[:2] - centre), class_k=gains(1, 1))
    row = held_row(system, derive_chain(system, speed_like), 1e-3)
    bend = numeric([system.x, system.u, system.t], row.bend)

    # At c = (1, 0), at rest, u = 0: p̈ = −d²/dt²‖x₁ − c‖² = −2·(x₁ − c)·400 in the first axis
    assert bend([3, 0, 0, 0], [0, 0], np.pi / 40)[0] == pytest.approx(-(2 * (3 - 1) * 400) * 1e-3 / 2, rel=1e-6)


@pytest.mark.parametrize(("gamma", "steep"), [(Cubic(gain=100.0), True), (Piecewise(gain=1.0, gain_below=9.0), False)])
def test_sampled_input_may_use_one_period_of_the_margin_only(gamma: Cubic, steep: bool) -> None:
    design = paper_design()
    system = design.system
    disk = replace(design.barriers[0], class_k=gains(10.0, gamma, 1.0))
    chain = derive_chain(system, disk)
    held = numeric([system.x, system.u], held_row(system, chain, 1e-3).value)
    plain = numeric([system.x, system.u], chain.psi[2])
    rest = numeric([system.x, system.u], system.rate(chain.psi[1]))
    far, near, u = [3, 0, 1, 0], [1.01, 0, 0, 0], [1, 2]
    p = numeric([system.x], chain.psi[1])(far)[0]

    assert held(near, u) == pytest.approx(plain(near, u))
    assert held(far, u) == pytest.approx(rest(far, u) + p / 1e-3 if steep else plain(far, u))


def test_a_linear_gain_that_a_period_can_use_is_left_alone() -> None:
    design = paper_design()
    chain = derive_chain(design.system, design.barriers[0])

    assert held_row(design.system, chain, 1e-3).value is chain.psi[2]
    assert held_row(design.system, chain, 0.2).value is not chain.psi[2]


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
            x = runge_kutta(lambda _, s, u=u: flow(s, np.array(u)), 0.0, x, made.design.dt_s / PARTS)  # type: ignore[misc]  # bound
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
    monkeypatch.setattr(passafe.answers.attempts, "ATTEMPTS", 1)
    decision = next(second_answers(made))

    assert decision.part("trust") == pytest.approx([made.design.limits.reach] * 2)


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
    with pytest.raises(DesignError, match=r"hold_s: got -0\.1, allowed a number from zero to 2048 periods"):
        paper_design(hold_s=-0.1)
