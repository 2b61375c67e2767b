"""Limits of the input as hard rows: magnitude, norm and rate, and the first input of all."""

from math import hypot

import casadi as ca
import numpy as np
import pytest
from core_designs import PAPER_START, drag_design, paper_design, random_state
from finite_differences import Array

from passafe import Barrier, FilterDesign, Linear, Passivity, System
from passafe.decision import Status
from passafe.design import Mode
from passafe.filter import SafetyPassivityFilter
from passafe.sampled_plant import SampledPlant
from passafe.symbolic import whole_program

ZERO = (0.0, 0.0)
LIMITS: dict[str, dict[str, object]] = {
    "magnitude": {"input_bound": (6.0, 3.0)},
    "norm": {"input_norm_bound": 5.0},
    "rate": {"input_rate_bound_per_s": 500.0},
    "all of them": {"input_bound": 7.0, "input_norm_bound": 8.0, "input_rate_bound_per_s": (1500.0, 2000.0)},
}


@pytest.mark.parametrize("name", LIMITS)
def test_no_input_of_a_run_is_beyond_the_limits(name: str) -> None:
    made = SafetyPassivityFilter(paper_design(**LIMITS[name]))
    limits, dt_s = made.design.limits, made.design.dt_s
    plant = SampledPlant(made.design.system, made.design.passivity.V, dt_s)
    sample, u, binding = plant.at(PAPER_START), ZERO, 0
    rates = np.array(limits.rise_per_s or (np.inf, np.inf)) * dt_s
    for k in range(1200):
        decision = made.decide(sample.x, u, ((-8.0, 5.0) if k < 600 else (9.0, -9.0)), ZERO)
        after = np.array(decision.u)
        assert (np.abs(after) <= limits.magnitude).all()
        assert (np.abs(after - u) <= rates * (1 + 1e-9) + 1e-9).all()
        assert limits.norm is None or hypot(*after) <= limits.norm * (1 + 1e-12)
        assert decision.status is not Status.UNCERTIFIED
        binding += bool((decision.duals[made.constraints :] > 1e-6).any())
        u = decision.u
        sample = plant.advance(sample.x, u)
    assert binding > 0 or name == "rate"


def test_the_rate_s_limit_is_used_to_the_full() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.OFF, input_rate_bound_per_s=(500.0, 800.0)))
    decision = made.decide(PAPER_START, (1.0, -2.0), (4000.0, -4000.0), ZERO)

    assert decision.u == pytest.approx((1.0 + 500.0 * made.design.dt_s, -2.0 - 800.0 * made.design.dt_s), rel=1e-12)


def best_on_a_grid(made: SafetyPassivityFilter, decision_parts: tuple[Array, Array, Array]) -> float:
    """Return the smallest ½‖u − u_ref‖² over a fine polar grid of the ball that keeps the constraints' rows."""
    G, d, u_ref = decision_parts
    norm = made.design.limits.norm or 0.0
    angle, length = np.meshgrid(np.linspace(-np.pi, np.pi, 2881), np.linspace(0, norm, 401))
    u = np.vstack(((length * np.cos(angle)).ravel(), (length * np.sin(angle)).ravel()))
    w = u - u_ref[:, None]
    kept = (G @ w >= d[:, None]).all(axis=0)
    return float((w[:, kept] ** 2).sum(axis=0).min() / 2)


def test_within_a_norm_the_answer_is_the_nearest_one() -> None:
    made = SafetyPassivityFilter(drag_design(mode=Mode.SAFE, input_norm_bound=3.0, between_samples=False))
    rng = np.random.default_rng(90)
    cut = 0
    while cut < 12:
        x, u, u_h = random_state(rng, 4, 2.0), random_state(rng, 2), 4000 * random_state(rng, 2)
        decision = made.decide(list(x), list(u), list(u_h), ZERO)
        if decision.status is not Status.MODIFIED or not (decision.duals[made.constraints + 4 :] > 0).any():
            continue
        cut += 1
        parts = decision.part("G").reshape((made.constraints, 2), order="F"), decision.part("d"), decision.part("u_ref")
        w = np.array(decision.u) - parts[2]

        assert hypot(*decision.u) == pytest.approx(3.0, rel=1e-6)
        assert decision.u == tuple(parts[2] + decision.part("z")[:2])  # nothing was left to shorten
        assert w @ w / 2 <= best_on_a_grid(made, parts) + 1e-3


def test_the_norm_is_kept_with_seven_axes_too() -> None:
    x, u = ca.SX.sym("x", 7), ca.SX.sym("u", 7)
    gamma = Linear(gain=2.0)
    sums = [(1 + 0.1 * i) * x[i] + 0.3 * x[i - 1] for i in range(7)]
    rows = [Barrier(name=f"x{i}", h=1.2 - total, class_k=(gamma, gamma)) for i, total in enumerate(sums)]
    made = SafetyPassivityFilter(
        FilterDesign(
            system=System(x=x, u=u, f=u, y=x),
            u_fb=-x,
            fail_safe=ca.SX.zeros(7),
            barriers=tuple(rows),
            passivity=Passivity(V=ca.sumsqr(x) / 2),
            k_i=90.0,
            dt_s=0.01,
            input_bound=50.0,
            input_norm_bound=4.0,
            mode=Mode.SAFE,
        )
    )
    rng = np.random.default_rng(91)
    seen = set()
    for _ in range(60):
        decision = made.decide(rng.uniform(0.3, 0.7, 7), rng.uniform(-1, 1, 7), rng.uniform(0, 30, 7), np.zeros(7))
        seen.add(decision.status)

        assert np.linalg.norm(decision.u) <= 4.0 * (1 + 1e-12)
    assert seen == {Status.MODIFIED}


def test_first_input_is_nearest_to_the_nominal_one() -> None:
    """The paper starts at u = 0, where its example's ψ₂ is outside the set that its theorem protects."""
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE, input_rate_bound_per_s=10.0))
    first = made.decide(PAPER_START, ZERO, (-3.0, 0.0), ZERO, start=True)
    later = made.decide(PAPER_START, ZERO, (-3.0, 0.0), ZERO)

    assert first.status is Status.PASSED
    assert first.u == pytest.approx((-18.0, -15.0))  # û = −10·2 + 5·1 + u_h
    assert np.abs(later.u).max() <= 0.01 + 1e-12
    held_back = made.decide((1.05, 0.0, -0.4, 0.0), ZERO, (-3.0, 0.0), ZERO, start=True)
    assert held_back.status is Status.MODIFIED
    assert held_back.psi[2] >= 0


def test_the_fail_safe_stays_within_the_limits() -> None:
    made = SafetyPassivityFilter(paper_design(input_norm_bound=3.0))
    decision = made.decide((float("nan"), 0.0, 5.0, -5.0), ZERO, ZERO, ZERO)

    assert decision.status is Status.UNCERTIFIED
    assert decision.u == pytest.approx((-3 / 2**0.5, 3 / 2**0.5))


def test_a_norm_that_no_tangent_brings_about_is_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole_program, "TANGENTS_PER_AXIS", 0)
    made = SafetyPassivityFilter(paper_design(mode=Mode.OFF, input_norm_bound=3.0))

    assert made.decide((0.0, 0.0, 0.0, 0.0), (2.0, 0.0), (1.0, 0.0), ZERO).status is Status.PASSED
    refused = made.decide((0.0, 0.0, 0.0, 0.0), (3.0, 0.0), (1e3, 0.0), ZERO)
    assert (refused.status, refused.u) == (Status.UNCERTIFIED, ZERO)
