"""Verdicts on runs whose metrics are known in closed form."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import PERIOD_NS, DampedPoint, Run, header, rollout, scenario, state
from passafe_protocol.messages import Certificate, FilterStatus, FilterTick, PlantInput, PlantPhase, PlantState
from passafe_services.tools.review.errors import MismatchedLogError
from passafe_services.tools.review.properties import Tolerances
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verdict_words import decide

REST = (0.0, 0.0)


def judged(run: Run, tmp_path: Path) -> Verdict:
    return Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)


def coasting(run: Run, *, steps: int = 200, away: float = 1.0) -> Run:
    """From (2, 0) at speed 1 away from the disk or towards it, without input."""
    rollout(run, x0=(2.0, 0.0, away, 0.0), u=lambda _: REST, steps=steps)
    return run


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


def test_an_input_beyond_the_bound_fails_where_it_was_sent(tmp_path: Path) -> None:
    run = coasting(Run(scenario(mode="off", input_bound=5.0)))
    run.replace(run.indices(PlantInput)[7], u=(0.0, -5.01))
    bounded = judged(run, tmp_path).properties["bounded"]
    assert (bounded.holds, bounded.worst, bounded.required) == (False, 5.01, True)
    assert bounded.at_s == pytest.approx(0.007)


@pytest.mark.parametrize(
    ("keys", "at", "beyond"),
    [
        ({"input_bound": [5.0, 3.0]}, (0.0, -3.5), 0.5),
        ({"input_low": -1.0}, (-1.25, 0.0), 0.25),
        ({"input_norm_bound": 4.0}, (3.0, 4.0), 1.0),
        ({"input_half_spaces": [{"weights": [3.0, 4.0], "bound": 10.0}]}, (2.0, 2.0), 0.8),
    ],
)
def test_an_input_beyond_one_of_many_limits_fails(
    tmp_path: Path, keys: dict[str, object], at: tuple[float, float], beyond: float
) -> None:
    run = coasting(Run(scenario(mode="off", **keys)))
    assert judged(run, tmp_path).properties["bounded"].holds
    run.replace(run.indices(PlantInput)[7], u=at)
    bounded = judged(run, tmp_path).properties["bounded"]
    assert (bounded.holds, bounded.worst) == (False, pytest.approx(beyond))
    assert bounded.requirement.startswith("input sent or applied beyond a limit by ≤ ")


def test_rates_are_judged_within_an_input_sequence(tmp_path: Path) -> None:
    limits = {"input_rate_low_per_s": -20.0, "input_rate_high_per_s": 10.0}
    run = coasting(Run(scenario(mode="off", **limits)))
    sent = run.indices(PlantInput)
    for k, place in enumerate(sent):
        run.replace(place, u=(0.009 * k, -0.019 * k), input_sequence_start_ns=0)
    assert judged(run, tmp_path).properties["bounded"].holds
    run.replace(sent[5], u=(0.06, -0.019 * 5))
    assert not judged(run, tmp_path).properties["bounded"].holds
    for place in sent[5:]:
        run.replace(place, input_sequence_start_ns=5_000_000)  # another sequence may begin with a jump
    run.replace(sent[6], u=(0.06, -0.019 * 6))
    assert judged(run, tmp_path).properties["bounded"].holds


def test_an_input_of_another_shape_is_beyond_every_bound(tmp_path: Path) -> None:
    run = coasting(Run(scenario(mode="off")))
    run.replace(run.indices(PlantInput)[7], u=(0.0, 0.0, 0.0))
    assert judged(run, tmp_path).properties["bounded"].worst == float("inf")


def test_u_norm_max_is_of_the_input_in_force(tmp_path: Path) -> None:
    run = Run(scenario(mode="off"))
    rollout(run, x0=(2.0, 0.0, 0.0, 0.0), u=lambda k: (3.0, 4.0) if k == 5 else REST, steps=10)
    verdict = judged(run, tmp_path)
    assert verdict.u_norm_max == pytest.approx(5.0)
    assert verdict.properties["bounded"].worst == 4.0


@pytest.mark.parametrize(
    ("certificate", "status", "holds"),
    [
        (Certificate("piqp", accepted=False, primal_residual=0, dual_residual=0, gap=0), "MODIFIED", False),
        (Certificate("piqp", accepted=True, primal_residual=2e-6, dual_residual=0, gap=0), "PASSED", False),
        (Certificate("piqp", accepted=True, primal_residual=0, dual_residual=0, gap=2e-6), "RELAXED", False),
        (Certificate("piqp", accepted=False, primal_residual=1, dual_residual=1, gap=1), "INFEASIBLE", True),
    ],
)
def test_an_answer_needs_a_certificate_and_a_fallback_does_not(
    tmp_path: Path, certificate: Certificate, status: str, *, holds: bool
) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=20)
    run.replace(run.indices(FilterTick)[5], certificate=certificate, status=FilterStatus[status])
    verdict = judged(run, tmp_path)
    certified = verdict.properties["certified"]
    assert certified.holds is holds
    assert certified.at_s == (None if holds else pytest.approx(0.005))
    assert verdict.properties["no-fallback"].holds is not holds
    assert verdict.verdict == "fails"


@pytest.mark.parametrize(("below", "holds"), [(2e-16, True), (1e-12, False), (0.0009, False)])
def test_h_may_be_below_zero_by_its_rounding_alone(tmp_path: Path, below: float, *, holds: bool) -> None:
    run = Run()
    run.add(header("plant", 0), state(0, (math.sqrt(1 - below), 0.0, 0.0, 0.0), REST))
    verdict = judged(run, tmp_path)
    safe = verdict.properties["safe"]
    assert verdict.h_min == pytest.approx(-below, abs=3e-16)
    assert safe.holds is holds
    assert safe.allowed.startswith("≥ -")
    assert float(safe.allowed.removeprefix("≥ ")) == pytest.approx(-8e-15, rel=0.2)  # 16 units of x₁, and its square's
    generous = Verdict.of(
        RunLog.read(tmp_path / "run.mcap"), DampedPoint(), derives=False, tolerances=Tolerances(h=0.01)
    )
    assert generous.properties["safe"].holds is True
    assert generous.tolerances.h == 0.01


def test_a_start_outside_of_the_protected_set_is_said(tmp_path: Path) -> None:
    run = Run(scenario(mode="safe"))
    # At 1.2 with speed −2: h = 0.44 and ψ₁ = −4.8 + 4.4. The robot stops by itself, far inside.
    rollout(run, x0=(1.2, 0.0, -2.0, 0.0), u=lambda _: REST, steps=20)
    verdict = judged(run, tmp_path)
    start = verdict.properties["protected-start"]
    assert (start.holds, start.required, start.worst, start.at_s) == (False, False, pytest.approx(-0.4), 0.0)
    assert verdict.words == "holds: the start was outside of the protected set: ψ1 of disk was -0.4"
    assert judged(coasting(Run(scenario(mode="safe"))), tmp_path).words == "holds: violated but not required: passive"


def test_a_mode_without_safety_says_nothing_of_its_start(tmp_path: Path) -> None:
    run = Run(scenario(mode="off"))
    rollout(run, x0=(1.2, 0.0, -2.0, 0.0), u=lambda _: REST, steps=5)
    assert judged(run, tmp_path).properties["protected-start"].note == ""


@pytest.mark.parametrize(("below", "holds"), [(0.049, True), (0.051, False)])
def test_passivity_has_a_tolerance(tmp_path: Path, below: float, *, holds: bool) -> None:
    run = Run()
    away = 0.1  # h_u = 2·away² − 2·distance·away without input
    run.add(header("plant", 0), state(0, ((2 * away**2 + below) / (2 * away), 0.0, away, 0.0), REST))
    verdict = judged(run, tmp_path)
    assert verdict.power_margin_min == pytest.approx(-below)
    assert verdict.properties["passive"].holds is holds


def test_states_that_the_model_does_not_explain_fail(tmp_path: Path) -> None:
    run = Run()
    states = rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=20)
    moved = states[9] + np.array([1e-4, 0, 0, 0])
    run.replace(run.indices(PlantState)[9], x=tuple(moved))
    consistent = judged(run, tmp_path).properties["consistent"]
    assert consistent.holds is False
    assert consistent.worst == pytest.approx(1e-4 / (1 + moved[0]), rel=1e-3)
    assert consistent.at_s == pytest.approx(0.009, abs=1.1e-3)


@pytest.mark.parametrize("missing", [PlantState, FilterTick, PlantInput])
def test_log_with_a_gap_is_unproven_and_locates_it(tmp_path: Path, missing: type) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda k: (0.01 * k, 0.0), steps=50)
    path = run.write(
        tmp_path / "gap.mcap",
        without=lambda head, body: isinstance(body, missing) and head.sequence in (20, 21),
    )
    verdict = Verdict.of(RunLog.read(path), DampedPoint(), derives=False)
    complete = verdict.properties["complete"]
    assert verdict.verdict == "unproven"
    assert (complete.holds, complete.worst) == (False, 2.0)
    assert complete.at_s == pytest.approx(0.019)
    assert sum(verdict.gaps.values()) == 2
    assert verdict.properties["consistent"].holds is True  # the gap is not evaluated


def test_a_violation_outweighs_a_gap(tmp_path: Path) -> None:
    run = coasting(Run())
    path = run.write(tmp_path / "gap.mcap", without=lambda head, _: head.sequence == 20)
    assert Verdict.of(RunLog.read(path), DampedPoint(), derives=False).verdict == "fails"


def test_a_log_that_begins_after_the_plant_did_is_unproven(tmp_path: Path) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=50)
    path = run.write(tmp_path / "late.mcap", without=lambda head, _: head.sequence < 10)
    verdict = Verdict.of(RunLog.read(path), DampedPoint(), derives=False)
    assert verdict.verdict == "unproven"
    assert verdict.missed_at_start["state"] == 10
    assert verdict.gaps["state"] == 0


def test_a_torn_log_is_unproven(tmp_path: Path) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=50)
    path = run.write(tmp_path / "torn.mcap")
    path.write_bytes(path.read_bytes()[:-8])  # only the last magic is gone: every message is still there
    whole = RunLog.read(path)
    assert whole.finished
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")])  # from DataEnd on
    verdict = Verdict.of(RunLog.read(path), DampedPoint(), derives=False)
    assert (verdict.finished, verdict.verdict, verdict.ticks) == (False, "unproven", 50)


def test_a_robot_that_waits_for_its_first_input_is_not_judged(tmp_path: Path) -> None:
    run = Run()
    inside = (0.5, 0.0, 1.0, 1.0)  # resting, whatever its velocity says
    for k in range(5):
        run.add(header("plant", k), state(0, inside, REST, phase=PlantPhase.WAITING))
    verdict = judged(run, tmp_path)
    assert verdict.h_min is None
    assert verdict.power_margin_min is None
    assert verdict.tank_min_j is None
    assert verdict.u_norm_max is None
    assert verdict.final_x is None
    assert verdict.properties["safe"].holds is None
    assert verdict.verdict == "unproven"


def test_duplicate_state_changes_nothing(tmp_path: Path) -> None:
    # A plant step that comes before the next period is over repeats the state.
    run = Run()
    states = rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=10)
    run.add(header("plant", 10), state(9, states[9], REST))
    run.add(header("plant", 11), state(10, DampedPoint().flow(states[9], np.zeros(2), 1e-3), REST))
    verdict = judged(run, tmp_path)
    assert verdict.verdict == "holds"
    assert verdict.duration_s == pytest.approx(0.010)


def test_restarted_plant_is_a_new_session(tmp_path: Path) -> None:
    run = Run(scenario(mode="safe"))
    for epoch, start in ((1, 2.0), (2, 3.0)):
        model, x = DampedPoint(), np.array([start, 0.0, -0.5, 0.0])
        for k in range(5):
            run.add(header("plant", k, epoch=epoch), state(k, x, REST))
            x = model.flow(x, np.zeros(2), PERIOD_NS * 1e-9)
    verdict = judged(run, tmp_path)
    assert verdict.properties["consistent"].holds is True  # no jump from the one to the other
    assert verdict.gaps["state"] == 0
    assert verdict.tank_min_j is not None
    assert verdict.tank_min_j > 0.99


def test_states_of_another_model_are_refused(tmp_path: Path) -> None:
    run = Run()
    run.add(header("plant", 0), state(0, (1.0, 2.0), (0.0,), y=(2.0,)))
    with pytest.raises(MismatchedLogError, match="state 0: got 2 numbers, allowed 4"):
        judged(run, tmp_path)


def test_a_state_that_overflows_is_a_violation(tmp_path: Path) -> None:
    run = Run()
    run.add(header("plant", 0), state(0, (1e200, 0.0, 1e200, 0.0), (1e200, 0.0), energy_stored_j=1e300))
    verdict = judged(run, tmp_path)
    assert verdict.properties["passive"].holds is False
    assert json.loads(verdict.model_dump_json())["power_margin_min"] is None


def test_the_json_holds_what_the_command_line_promises(tmp_path: Path) -> None:
    content = json.loads(judged(coasting(Run()), tmp_path).model_dump_json())
    promised = (
        "scenario mode duration_s ticks steps_skipped gaps h_min power_margin_min tank_min_j u_norm_max "
        "status_counts solve_us_p50 solve_us_p99 late_us_p50 late_us_p99 command_age_ms_p50 "
        "command_age_ms_p99 commands final_x properties verdict"
    )
    assert set(promised.split()) <= set(content)
    assert set(content["properties"]["safe"]) >= {"holds", "worst", "at_s"}
    assert content["tolerances"]["h"] == 0.0
    assert content["tolerances"]["power_margin_w"] == 0.05


@pytest.mark.parametrize(
    ("safe", "complete", "outcome"),
    [
        (True, True, "holds"),
        (False, True, "fails"),
        (False, False, "fails"),
        (True, False, "unproven"),
        (None, True, "unproven"),
    ],
)
def test_decision(safe: bool | None, complete: bool, outcome: str) -> None:
    def entry(*, holds: bool | None, required: bool = True) -> Property:
        return Property(holds=holds, required=required, worst=None, at_s=None, requirement="")

    properties = {
        "safe": entry(holds=safe),
        "complete": entry(holds=complete),
        "passive": entry(holds=False, required=False),
    }
    assert decide(properties) == outcome
