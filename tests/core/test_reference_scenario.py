"""The table of ``docs/theory.md``, section 3: ``notomista-cai-2020`` in closed loop, dt 1 ms, exact plant."""

from collections import Counter
from dataclasses import dataclass
from math import exp

import casadi as ca
import numpy as np
import pytest
from core_designs import PAPER_START, paper_design
from finite_differences import Array

from passafe.decision import Status
from passafe.design import Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.sampled_plant import SampledPlant, held_flow

DT_S = 1e-3
MOMENTS = 4


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run: states at the samples, and the worst values also between them."""

    final: Array
    h_min: float
    h_u_min: float
    u_max: float
    statuses: Counter[Status]
    slack_max: float


def request(t: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """u_h and its rate: a lag from 0 to [−3, 0] with time constant 0.2 s."""
    left = exp(-t / 0.2)
    return (-3 * (1 - left), 0.0), (-15 * left, 0.0)


def close_the_loop(law: Law, mode: Mode, duration_s: float = 10.0) -> Run:
    made = SafetyPassivityFilter(paper_design(law=law, mode=mode))
    plant = SampledPlant(made.design.system, made.design.passivity.V, DT_S)
    sample = plant.at(PAPER_START)
    u: tuple[float, ...] = (0.0, 0.0)
    states, inputs, statuses, slack = [], [], Counter[Status](), 0.0
    for k in range(round(duration_s / DT_S)):
        decision = made.decide(sample.x, u, *request(k * DT_S))
        u = decision.u
        states.append(sample.x)
        inputs.append(u)
        statuses[decision.status] += 1
        slack = max(slack, decision.slack)
        sample = plant.advance(sample.x, u)
    h, h_u = between_samples(made, np.array(states), np.array(inputs))
    return Run(
        final=np.array(sample.x[:2]),
        h_min=h,
        h_u_min=h_u,
        u_max=float(np.abs(inputs).max()),
        statuses=statuses,
        slack_max=slack,
    )


def between_samples(made: SafetyPassivityFilter, states: Array, inputs: Array) -> tuple[float, float]:
    """Smallest h = ‖x₁‖² − 1 and h_u = 2‖x₂‖² − 2x₁ᵀx₂ − x₂ᵀu at the samples and at moments between them."""
    system = made.design.system
    h, h_u = [], []
    for moment in range(MOMENTS):
        flow = ca.Function("flow", [system.x, system.u], [held_flow(system, DT_S * moment / MOMENTS)[0]])
        x = np.array(flow(states.T, inputs.T)).T
        x1, x2 = x[:, :2], x[:, 2:]
        h.append(np.sum(x1**2, 1).min() - 1)
        h_u.append((2 * np.sum(x2**2, 1) - 2 * np.sum(x1 * x2, 1) - np.sum(x2 * inputs, 1)).min())
    return float(min(h)), float(min(h_u))


@pytest.fixture(scope="module")
def off() -> Run:
    return close_the_loop(Law.SAMPLED, Mode.OFF)


def test_off_goes_through_the_disk_and_generates_energy(off: Run) -> None:
    assert off.final == pytest.approx([-0.3, 0.0], abs=1e-3)
    assert off.h_min == pytest.approx(-0.968, abs=1e-3)
    assert off.h_u_min == pytest.approx(-16.6, abs=0.1)
    assert off.statuses == {Status.PASSED: 10_000}


def test_safe_stays_out_of_the_disk_and_creeps_along_it() -> None:
    run = close_the_loop(Law.SAMPLED, Mode.SAFE)

    assert run.final == pytest.approx([-0.999, 0.032], abs=1e-3)
    assert run.h_min >= -1e-6
    assert run.h_u_min == pytest.approx(-16.6, abs=0.1)
    assert set(run.statuses) == {Status.PASSED, Status.MODIFIED}


def test_passive_reaches_the_target_without_generating_energy() -> None:
    run = close_the_loop(Law.SAMPLED, Mode.PASSIVE)

    assert run.final == pytest.approx([-0.2953, 0.0018], abs=1e-4)
    assert run.h_min == pytest.approx(-0.967, abs=1e-3)
    assert run.h_u_min >= -1e-3
    assert run.slack_max <= 1e-3
    assert set(run.statuses) == {Status.PASSED, Status.MODIFIED}


def test_both_is_safe_and_passive() -> None:
    run = close_the_loop(Law.SAMPLED, Mode.BOTH)

    assert run.final == pytest.approx([-0.999, 0.032], abs=1e-3)
    assert run.h_min >= -1e-6
    assert run.h_u_min >= -1e-4
    assert run.u_max < 10
    assert set(run.statuses) == {Status.PASSED, Status.MODIFIED}


def test_the_papers_law_is_safe_up_to_its_sampling_error() -> None:
    run = close_the_loop(Law.CONTINUOUS, Mode.SAFE)

    assert run.final == pytest.approx([-0.999, 0.032], abs=1e-3)
    assert run.h_min == pytest.approx(-2.8e-4, abs=1e-5)


def test_papers_passive_law_diverges_within_bounds(off: Run) -> None:
    """Without a bound u passes 1e8 at 2.23 s; with one the rows become infeasible instead, and the status says so."""
    before = close_the_loop(Law.CONTINUOUS, Mode.PASSIVE, 2.0)
    run = close_the_loop(Law.CONTINUOUS, Mode.PASSIVE, 3.0)

    assert set(before.statuses) == {Status.PASSED, Status.MODIFIED}
    assert before.u_max < off.u_max
    assert run.u_max > 50
    assert run.u_max <= 100
    assert run.statuses[Status.INFEASIBLE] > 10
    assert np.isfinite(run.final).all()
