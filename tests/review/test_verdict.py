"""Verdicts on runs whose metrics are known in closed form."""

import math
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import DampedPoint, Run, header, rollout, scenario, state
from judged_runs import REST, coasting, judged
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict


def test_a_run_that_keeps_everything_holds(tmp_path: Path) -> None:
    run = Run()
    # Towards the disk without input: h_u = −2x₁ᵀx₂ + 2σ‖x₂‖² > 0, and the robot stops at distance 1.5.
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=200)
    verdict = judged(run, tmp_path)
    assert verdict.verdict == "holds"
    assert [name for name, entry in verdict.properties.items() if entry.required and entry.holds is not True] == []
    assert verdict.scenario == "notomista-cai-2020"
    assert (verdict.mode, verdict.law, verdict.driver, verdict.finished) == ("both", "sampled", "live", True)
    assert verdict.ticks == 200
    assert verdict.steps_skipped == 0
    assert verdict.duration_s == pytest.approx(0.199)
    assert verdict.status_counts == {"MODIFIED": 200}
    reach = 1 - math.exp(-0.199)
    assert verdict.final_x == pytest.approx((2 - 0.5 * reach, 0.0, -0.5 * math.exp(-0.199), 0.0))
    assert verdict.h_min == pytest.approx((2 - 0.5 * reach) ** 2 - 1, abs=1e-12)


def test_h_and_power_margin_are_recomputed_not_read_from_ticks(tmp_path: Path) -> None:
    verdict = judged(coasting(Run()), tmp_path)  # the ticks claim a power margin of 99
    # h_u = 2‖x₂‖² − 2x₁ᵀx₂ = 4e⁻²ᵗ − 6e⁻ᵗ without input, which falls until e⁻ᵗ = 3/4.
    lowest = 4 * math.exp(-2 * 0.199) - 6 * math.exp(-0.199)
    assert verdict.power_margin_min == pytest.approx(lowest)
    assert verdict.h_min == pytest.approx(3.0)
    assert verdict.verdict == "fails"
    passive = verdict.properties["passive"]
    assert (passive.holds, passive.required, passive.at_s) == (False, True, pytest.approx(0.199))
    assert passive.worst == verdict.power_margin_min


def test_the_barrier_that_came_nearest_is_named(tmp_path: Path) -> None:
    assert judged(coasting(Run()), tmp_path).h_min_barrier == "disk"
    assert (
        Verdict.of(RunLog.read(Run().write(tmp_path / "none.mcap")), DampedPoint(), derives=False).h_min_barrier is None
    )


def test_the_worst_between_two_samples_is_found(tmp_path: Path) -> None:
    # One period of 1 s from x₁ = 1.2, x₂ = −1 with u = 3: x₁(s) = 1.2 − 4(1 − e⁻ˢ) + 3s, least at ln(4/3).
    run = Run()
    rollout(run, x0=(1.2, 0.0, -1.0, 0.0), u=lambda _: (3.0, 0.0), steps=2, period=1000)
    log = RunLog.read(run.write(tmp_path / "run.mcap"))
    lowest = 1.2 - 4 * (1 - 3 / 4) + 3 * math.log(4 / 3)
    fine = Verdict.of(log, DampedPoint(), derives=False, points_per_period=1000)
    assert fine.h_min_at_samples == pytest.approx(1.2**2 - 1)
    assert fine.h_min == pytest.approx(lowest**2 - 1, abs=1e-5)
    assert fine.properties["safe"].at_s == pytest.approx(math.log(4 / 3), abs=2e-3)
    assert fine.properties["safe"].holds is True
    coarse = Verdict.of(log, DampedPoint(), derives=False)
    grid = 1.2 - 4 * (1 - np.exp(-np.arange(11) / 10)) + 3 * np.arange(11) / 10
    assert coarse.points_per_period == 10
    assert coarse.h_min == pytest.approx(np.min(grid) ** 2 - 1, abs=1e-12)


def test_the_input_of_a_period_counts_until_its_end(tmp_path: Path) -> None:
    # Under u = −1 from rest, h_u = −x₂ᵀu − 2x₁ᵀx₂ + 2‖x₂‖² first falls below 0 for x₁ = −0.1 …
    run = Run()
    rollout(run, x0=(0.0, 0.0, 0.0, 0.0), u=lambda k: (1.0, 0.0) if k == 0 else REST, steps=2)
    verdict = judged(run, tmp_path)
    # … while at both samples it is 0 or more: u is 0 at the second one.
    velocity = 1 - math.exp(-1e-3)
    position = 1e-3 - velocity
    end = -velocity - 2 * position * velocity + 2 * velocity**2
    assert verdict.power_margin_min_at_samples == pytest.approx(0.0, abs=1e-12)
    assert verdict.power_margin_min == pytest.approx(end)


def test_entering_the_disk_fails_only_if_safety_is_required(tmp_path: Path) -> None:
    for mode, outcome in (("safe", "fails"), ("off", "holds")):
        run = Run(scenario(mode=mode))
        rollout(run, x0=(1.01, 0.0, -1.0, 0.0), u=lambda _: REST, steps=100)
        verdict = judged(run, tmp_path)
        safe = verdict.properties["safe"]
        reach = 1 - math.exp(-0.099)
        assert safe.worst == pytest.approx((1.01 - reach) ** 2 - 1)
        assert safe.at_s == pytest.approx(0.099)
        assert (safe.holds, safe.required, verdict.verdict) == (False, mode == "safe", outcome)


def test_passivity_by_tank_is_judged_by_the_ledger(tmp_path: Path) -> None:
    run = coasting(Run(scenario(kind="tank")))
    verdict = judged(run, tmp_path)
    # Without input E = E(0) − ΔV; V = ‖x₁‖² + ‖x₂‖² grows from 5 as the robot coasts outward.
    reach, decay = 1 - math.exp(-0.199), math.exp(-0.199)
    assert verdict.tank_min_j == pytest.approx(1 - ((2 + reach) ** 2 + decay**2 - 5))
    passive = verdict.properties["passive"]
    assert passive.worst == verdict.tank_min_j
    assert passive.holds is True
    longer = judged(coasting(Run(scenario(kind="tank")), steps=1000), tmp_path)
    assert longer.properties["passive"].holds is False
    assert longer.verdict == "fails"


def test_the_tank_forgets_what_is_above_its_maximum(tmp_path: Path) -> None:
    passivity = {"tank_initial_j": 1.0, "tank_reserve_j": 0.0, "tank_max_j": 1.5}
    run = Run(scenario(passivity=passivity))
    for k, stored_j in enumerate((4.0, 2.0, 3.0)):  # +2 is cut to +0.5, then −1; every other state is missing
        run.add(header("plant", 2 * k), state(k, (2.0, 0.0, 0.0, 0.0), REST, energy_stored_j=stored_j))
    assert judged(run, tmp_path).tank_min_j == pytest.approx(0.5)
