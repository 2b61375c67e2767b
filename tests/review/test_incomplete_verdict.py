"""Verdicts on logs that lack something, or hold more than one session."""

import json
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import PERIOD_NS, DampedPoint, Run, header, rollout, scenario, state
from judged_runs import REST, coasting, judged
from passafe_protocol.messages import FilterTick, PlantInput, PlantPhase, PlantState
from passafe_services.tools.review.errors import MismatchedLogError
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verdict_words import decide


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
