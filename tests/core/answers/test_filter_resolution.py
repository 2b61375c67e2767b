"""Ways out of a decision whose rows are not kept at once: what is claimed, and what is sent."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import paper_design, pump_design, random_state

import passafe.answers.attempts
import passafe.filter
from passafe.answers.replaced_answer import BACKUP
from passafe.barrier_chain import Barrier
from passafe.decision import Status
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System

ZERO = (0.0, 0.0)


def test_slack_without_margins_is_the_power_at_the_sample() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.PASSIVE, between_samples=False))
    decision = made.decide((5.0, 0.0, 1.0, 0.0), ZERO, (300.0, 0.0), ZERO)

    assert decision.slack == pytest.approx(max(-decision.power_margin, 0.0), abs=1e-9)
    assert decision.part("power_deviation")[0] == 0


def test_the_continuous_law_has_nothing_to_guard() -> None:
    """Its answers are compared with no course, in the set or outside of it: it is there for comparison."""
    design = paper_design(law=Law.CONTINUOUS, mode=Mode.SAFE)
    plain, guarded = (SafetyPassivityFilter(replace(design, gatekeeper=on)) for on in (False, True))
    for x in ((2.0, 2.0, -1.0, -1.0), (1.1, 0.0, -3.0, 0.0)):
        assert guarded.decide(x, ZERO, ZERO, ZERO).u == plain.decide(x, ZERO, ZERO, ZERO).u


def test_without_margins_no_course_is_compared() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE, between_samples=False))
    decision = made.decide((1.2, 0.0, -3.0, 0.0), ZERO, ZERO, ZERO)

    assert decision.assessment.lowest_psi < 0
    assert decision.status is Status.MODIFIED
    assert decision.solver != BACKUP


@pytest.mark.parametrize("x", [(0.4, 1.1), (0.8, 0.4), (0.95, 0.1)])
def test_a_saturated_drive_is_led_back_to_where_it_acts(x: tuple[float, float]) -> None:
    """ẍ = clip(u, ±4) before a wall at 1, u = 8 before: nearest is −6x₂ + 9(1 − x₁) ≥ u, far from the tangent."""
    state, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=state, u=u, f=ca.vertcat(state[1], ca.fmin(ca.fmax(u, -4), 4)), y=state[1]),
        u_fb=ca.SX(0),
        fail_safe=-4 * state[1],
        barriers=(Barrier(name="wall", h=1 - state[0], class_k=(3.0, 3.0, 3.0)),),
        passivity=Passivity(V=state[1] ** 2 / 2),
        k_i=10.0,
        dt_s=2e-3,
        input_bound=15.0,
        mode=Mode.SAFE,
    )
    decision = SafetyPassivityFilter(design).decide(x, (8.0,), (8.0,), (0.0,))

    assert decision.status is Status.MODIFIED
    assert decision.u[0] == pytest.approx(-6 * x[1] + 9 * (1 - x[0]), abs=2e-3)  # less a margin of half a period


def test_a_backup_after_a_confined_answer_has_all_the_limits() -> None:
    """A trust region confines an answer, never the backup law's input."""
    design = paper_design(mode=Mode.SAFE, gatekeeper=True)
    made = SafetyPassivityFilter(design)
    x = (3.0, 0.0, -2.0, 0.0)
    block = made._block
    made.decide(x, ZERO, ZERO, ZERO)
    attempt = made._attempts.confined(np.array([50.0, 50.0]), np.array([1.0, 1.0]))
    sent = made._choice._replaced.send_backup(attempt)

    assert sent.solver == BACKUP
    assert block.evaluation.u_plus == pytest.approx([18.0, 0.0])  # −K x₂, K = 9


def test_tangents_that_do_not_settle_claim_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without margins, too, a row that is bent has to be kept by the answer itself, not by its tangent."""
    made = SafetyPassivityFilter(pump_design(between_samples=False))
    rng = np.random.default_rng(11)
    requests = [tuple(random_state(rng, 2).tolist() for _ in range(3)) for _ in range(200)]
    moved = [
        request
        for request in requests
        for decision in [made.decide(*request, ZERO, 1.0)]
        if decision.status is Status.MODIFIED and decision.part("u_lin").tolist() != request[1]
    ]
    monkeypatch.setattr(passafe.answers.attempts, "ATTEMPTS", 0)

    decisions = [made.decide(*request, ZERO, 1.0) for request in moved]
    kept = [decision.part("shortfall")[0] <= 0 for decision in decisions if decision.status is not Status.UNCERTIFIED]
    assert len(kept) < len(decisions)
    assert all(kept)


def test_at_the_start_no_rate_slows_the_backup_law() -> None:
    """At (0.9, 0) with 2 m/s no input keeps the wall: the backup's −K x₂ is sent whole, and so it was rolled out."""
    robot = paper_design(mode=Mode.SAFE, input_rate_bound_per_s=10.0, input_bound=30.0)
    wall = Barrier(name="wall", h=1 - robot.system.x[0], class_k=(10.0, 10.0, 10.0))
    made = SafetyPassivityFilter(replace(robot, barriers=(wall,)))
    x = (0.9, 0.0, 2.0, 0.0)
    block = made._block
    made.decide(x, ZERO, ZERO, ZERO, start=True)

    assert made._choice._replaced.input_before() == pytest.approx([-18.0, 0.0])
    made.decide(x, (1.0, 2.0), ZERO, ZERO)
    assert made._choice._replaced.input_before().tolist() == [1.0, 2.0]
    assert block.request.start[0] == 0


def test_slack_does_not_grow_where_tangents_do_not_settle() -> None:
    """Near rest at 250 Hz answers alternate between the two sides of the energy's demand: all take about 0.01 W.

    With a margin for every input the program took 88 W, and the robot the largest input.
    """
    made = SafetyPassivityFilter(paper_design(dt_s=0.004, hold_s=0.01))
    x = (1.3948801180973098, 0.10136327781540547, 0.016451115345364017, 0.005126325482755462)
    before = (-2.2569537059880673, -1.187987378526719)

    decision = made.decide(x, before, (15.0, 0.0), (0.0, 0.0), t_s=1.976)

    assert decision.status is Status.RELAXED
    assert decision.slack < 0.02
    assert np.abs(np.subtract(decision.u, before)).max() < 1.5
