"""The gatekeeper on a double integrator whose rows promise more braking than its limits give."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from passafe.barrier_chain import Barrier, derive_chains
from passafe.checks.backup_start import backup_findings, is_kept_from
from passafe.class_k import Linear
from passafe.courses.backup_rollout import BackupRollout
from passafe.courses.fallback import Fallback
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Severity
from passafe.passivity import Passivity
from passafe.system import System

DT_S = 0.01


def racer(**changes: object) -> FilterDesign:
    """Return ẍ = u, |u| ≤ 1, to stay left of 1 with gains of 20/s; the backup law brakes fully down to 1/50 m/s."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1]),
        u_fb=ca.SX(0),
        fail_safe=-50 * x[1],
        barriers=(Barrier(name="wall", h=1 - x[0], class_k=(Linear(gain=20.0),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=1.0,
        dt_s=DT_S,
        input_bound=1.0,
        mode=Mode.SAFE,
    )
    return replace(design, **changes)  # type: ignore[arg-type]  # by name


def drive(design: FilterDesign) -> tuple[list[float], set[Status], list[bool]]:
    """Return h, statuses and whether each state was backed, with full input to the wall from rest for 6 s."""
    made = SafetyPassivityFilter(design)
    judge = Fallback(design, made.chains)
    x, u = np.zeros(2), np.zeros(1)
    heights, statuses, backed = [], set(), []
    for k in range(600):
        backed.append(judge.keeps(x, k * DT_S, u))
        decision = made.decide(x, u, (1.0,), (0.0,), start=k == 0)
        statuses.add(decision.status)
        u = np.array(decision.u)
        x = np.array([x[0] + DT_S * x[1] + DT_S**2 / 2 * u[0], x[1] + DT_S * u[0]])
        heights.append(1 - x[0])
    return heights, statuses, backed


def test_rows_alone_run_into_the_wall() -> None:
    heights, _, _ = drive(racer())

    assert min(heights) < -0.1


def test_gatekeeper_stays_backed_and_keeps_the_wall() -> None:
    """Once backed, always backed: an answer is sent only if the backup law keeps the wall from where it leads."""
    heights, statuses, backed = drive(racer(gatekeeper=True))

    assert all(backed)
    assert Status.BACKUP in statuses
    assert 0.0 <= min(heights) < 0.1


@pytest.mark.parametrize(("v", "is_kept"), [(0.5, True), (1.3, True), (1.5, False)])
def test_course_of_braking_has_the_stopping_distance(v: float, is_kept: bool) -> None:
    """From v it stops after v²/2, within the rounding-off of the last 1/50 m/s: 1 m is enough up to √2."""
    design = racer()
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    course = BackupRollout(design, chains).course(np.array([0.0, v]), 0.0, np.zeros(1), 0)

    assert course.is_proven
    assert course.comes_to_rest
    assert course.is_safe is is_kept
    assert course.lowest == pytest.approx(1 - v**2 / 2, abs=1e-3)
    assert course.kept_periods == pytest.approx(np.inf if is_kept else (v - np.sqrt(v**2 - 2)) / DT_S, abs=1.0)


@pytest.mark.parametrize("seed", range(2))
def test_gatekeeper_counts_inputs_of_the_law_that_are_lost(seed: int) -> None:
    """A brake that ramps up takes longer where inputs are lost and the ones before are held."""
    design = racer(gatekeeper=True, input_rate_bound_per_s=4.0, hold_s=4 * DT_S)
    design = replace(design, fail_safe=-15 * design.system.x[1])
    made, draws = SafetyPassivityFilter(design), np.random.default_rng(seed)
    x, u, held = np.zeros(2), np.zeros(1), 0
    for k in range(250):
        decision = made.decide(x, u, (1.0,), (0.0,), start=k == 0)
        is_lost = k > 0 and held < 3 and draws.random() < 0.7
        held = held + 1 if is_lost else 0
        u = u if is_lost else np.array(decision.u)
        x = np.array([x[0] + DT_S * x[1] + DT_S**2 / 2 * u[0], x[1] + DT_S * u[0]])

        assert x[0] <= 1.0


@pytest.mark.parametrize(("gain", "is_reported"), [(15.0, False), (60.0, True)])
def test_a_law_that_diverges_if_held_is_reported(gain: float, is_reported: bool) -> None:
    """Sent every 10 ms −60·v settles; each input of it held for 40 ms, it swings ever further."""
    design = racer(gatekeeper=True, hold_s=4 * DT_S, input_bound=100.0)
    made = SafetyPassivityFilter(replace(design, fail_safe=-gain * design.system.x[1]))
    (finding,) = backup_findings(made, (0.95, 0.5))

    assert (finding.severity is Severity.WARNING) is is_reported
    assert ("inputs are lost" in finding.advice) is is_reported
    assert is_kept_from(made, (0.95, 0.5)) is not is_reported
