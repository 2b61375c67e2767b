"""Whatever the network does, an input takes effect only in the state it was made for, and the loop comes back.

Links are cut, messages delayed, lost and overtaken, processes killed; all in lockstep, so that a case that fails is the
same the next time.
"""

from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from input_sequence_run import COMMANDS, INPUTS, RATE_HZ, SLOW, STATES, InputSequenceRun, bad_links
from passafe_protocol.messages import FilterTick, PlantInput, PlantPhase
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.run_log import RunLog

ROUND_TRIPS = 4
"""Round trips within which a loop whose network works again follows an input sequence, beside the play-out time."""

ESTIMATORS = [{"kind": "as-sent"}, {"kind": "white-acceleration", "agility": 30.0, "resolution": 0.1}]

LOST_START_S = 3.0
"""How long the filter waits for a plant at rest before it takes the first input for lost."""


def links_of(rng: Random) -> dict[str, object]:
    """Return settings of the three links, each its own."""
    return {
        f"links.{name}": {
            "delay_s": rng.choice([0.0, 0.003, 0.05, 0.3]),
            "jitter_s": rng.choice([0.0, 0.01, 0.05]),
            "loss": rng.choice([0.0, 0.1, 0.3, 0.6]),
            "seed": rng.randrange(1000),
        }
        for name in ("operator-to-filter", "filter-to-plant", "plant-to-filter")
    }


def require_exact(run: InputSequenceRun, least: int = 1) -> None:
    """Demand that inputs took effect, each in the very state it was decided for."""
    effective, wrong = run.inexact()
    assert wrong == []
    assert effective >= least


@settings(max_examples=8)
@given(
    delay_s=st.floats(0.0, 0.3),
    jitter_s=st.floats(0.0, 0.05),
    loss=st.floats(0.0, 0.6),
    seed=st.integers(0, 10_000),
)
@example(delay_s=0.3, jitter_s=0.05, loss=0.6, seed=0)
@example(delay_s=0.0, jitter_s=0.0, loss=0.0, seed=0)
def test_every_input_meets_its_predicted_state_and_h_is_positive(
    delay_s: float, jitter_s: float, loss: float, seed: int
) -> None:
    run = InputSequenceRun(**bad_links(delay_s=delay_s, jitter_s=jitter_s, loss=loss, seed=seed)).run(2.0)

    require_exact(run)
    assert run.least_h() >= 0.0


@pytest.mark.parametrize("seed", range(4))
def test_links_of_different_quality_change_nothing_about_it(seed: int) -> None:
    run = InputSequenceRun(**links_of(Random(seed)), filter__mode="safe" if seed % 2 else "both").run(2.0)

    require_exact(run)
    assert run.least_h() >= 0.0


@pytest.mark.parametrize("repeats", [0, 1, 64])
def test_it_does_not_depend_on_how_many_inputs_a_message_repeats(repeats: int) -> None:
    run = InputSequenceRun(**bad_links(delay_s=0.02, jitter_s=0.02, loss=0.1, seed=2), filter__repeats=repeats)
    run.run(0.5 + (LOST_START_S if repeats == 0 else 0.0))

    require_exact(run)
    assert run.least_h() >= 0.0


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("notomista-cai-2020", {"plant.model": "drag-point", "plant.parameters": {"drag": 0.5}}),
        ("two-robots", {"filter.repeats": 16}),
        ("moving-disk", {}),
    ],
)
def test_nonlinear_and_larger_plants_are_predicted_bit_exactly(name: str, overrides: dict[str, object]) -> None:
    run = InputSequenceRun(name, **overrides, **bad_links(delay_s=0.06, jitter_s=0.03, loss=0.3, seed=3)).run(1.5)

    require_exact(run, least=50)
    assert len(run.sequence_breaks()) > 0
    assert run.least_h() >= 0.0


def test_without_delay_nothing_is_missing_and_runs_are_identical() -> None:
    first, second = InputSequenceRun().run(2.0), InputSequenceRun().run(2.0)

    assert first.sequence_breaks() == []
    assert {state.phase for state in first.trajectory()} == {PlantPhase.RUNNING}
    require_exact(first, least=390)
    assert first.wire() == second.wire()


def test_constant_delay_breaks_nothing_either() -> None:
    run = InputSequenceRun(**bad_links(delay_s=0.2)).run(3.0)

    assert run.sequence_breaks() == []
    assert run.least_h() >= 0.0


def test_two_runs_over_a_bad_network_are_byte_identical() -> None:
    overrides = bad_links(delay_s=0.05, jitter_s=0.03, loss=0.3, seed=7)

    assert InputSequenceRun(**overrides).run(1.5).wire() == InputSequenceRun(**overrides).run(1.5).wire()


def test_without_play_out_time_and_without_delay_the_loop_runs() -> None:
    run = InputSequenceRun(plant__playout_s=0.0).run(1.0)

    require_exact(run, least=190)
    assert run.in_sequence


@pytest.mark.parametrize("cut", [INPUTS, STATES])
@pytest.mark.parametrize("outage_s", [0.5, 2.0])
def test_outage_leads_to_the_fail_safe_and_back_without_a_jump(cut: type, outage_s: float) -> None:
    run = InputSequenceRun(**bad_links("filter-to-plant", "plant-to-filter", delay_s=0.04)).run(1.0)
    node = run.plant if cut is INPUTS else run.filter
    node.severed = {cut}
    run.run(outage_s)
    assert run.state.phase is PlantPhase.FAIL_SAFE
    node.severed = set()
    until_sequence_s = run.seconds_until_sequence(1.0)
    run.run(0.5)

    assert until_sequence_s <= ROUND_TRIPS * 0.08
    require_exact(run)
    assert run.least_h() >= 0.0
    assert_no_jump(run)


def assert_no_jump(run: InputSequenceRun) -> None:
    """Check that the first input after a fail-safe is u⁺ = u + dt(φ + v), u the fail-safe's last input.

    So ‖u⁺ − u‖ ≤ dt(‖φ‖ + ‖v‖), where φ tracks û and v is what the rows demand.
    """
    states, dt_s = run.trajectory(), run.scenario.dt_s
    ticks = {(tick.effective_plant_ns, tick.tick): tick for tick in run.ticks()}
    sequenced = [
        (before.u, ticks[after.plant_ns, after.applied_tick])
        for before, after in pairwise(states)
        if before.phase is not PlantPhase.RUNNING and after.phase is PlantPhase.RUNNING
    ]
    assert sequenced
    for before, tick in sequenced:
        step = np.array(tick.u) - before
        assert step == pytest.approx(dt_s * (np.array(tick.phi) + tick.v), abs=1e-9)
        assert np.linalg.norm(step) <= dt_s * (np.linalg.norm(tick.phi) + np.linalg.norm(tick.v)) + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_a_filter_that_is_killed_and_started_again_takes_over(seed: int) -> None:
    rng = Random(seed)
    delay_s = rng.choice([0.0, 0.02, 0.1])
    loss = rng.choice([0.0, 0.2])
    run = InputSequenceRun(**bad_links("filter-to-plant", "plant-to-filter", delay_s=delay_s, loss=loss, seed=seed))
    run.run(rng.uniform(0.0, 1.2))
    run.restart_filter(dead_s=rng.choice([0.0, 0.005, 0.1, 0.4]))
    run.run(2 * delay_s + 0.1)  # what the one before sent has run out
    until_sequence_s = run.seconds_until_sequence(3.0)
    run.run(0.3)

    assert until_sequence_s <= ROUND_TRIPS * (2 * delay_s + 0.05)
    require_exact(run)
    assert run.least_h() >= 0.0


@pytest.mark.parametrize("seed", range(4))
def test_restarted_plant_gets_a_sequence_of_its_own(seed: int) -> None:
    rng = Random(seed)
    run = InputSequenceRun(**bad_links("filter-to-plant", "plant-to-filter", delay_s=rng.choice([0.0, 0.1])))
    run.run(rng.uniform(0.01, 1.0))
    run.restart_plant()
    run.sent.clear()
    run.run(0.6)

    assert run.in_sequence
    assert run.trajectory()[0].x == run.scenario.plant.x0
    require_exact(run)


@pytest.mark.parametrize("seed", range(12))
def test_new_sequence_begins_after_a_burst_of_loss(seed: int) -> None:
    rng = Random(100 + seed)
    delay_s = rng.choice([0.0, 0.05, 0.3])
    run = InputSequenceRun(**bad_links("filter-to-plant", "plant-to-filter", delay_s=delay_s, jitter_s=0.01, seed=seed))
    run.run(rng.choice([0.0, 0.01, 0.7, 1.5]))
    cuts = rng.choice([{INPUTS}, {STATES}, {INPUTS, STATES}, {INPUTS, STATES, COMMANDS}])
    run.plant.severed = run.filter.severed = cuts
    run.run(rng.choice([0.05, 0.4, 1.0, 5.0]))
    run.plant.severed = run.filter.severed = set()
    run.run(2 * delay_s + 0.05)
    until_sequence_s = run.seconds_until_sequence(8.0)
    run.run(0.2)

    assert until_sequence_s <= LOST_START_S + ROUND_TRIPS * (2 * delay_s + 0.05)
    require_exact(run)
    assert run.least_h() >= 0.0


@pytest.mark.parametrize("seed", range(3))
def test_sequence_begins_once_restarting_nodes_stay_up(seed: int) -> None:
    rng = Random(seed)
    run = InputSequenceRun(**bad_links(delay_s=0.02, jitter_s=0.02, loss=0.2, seed=seed))
    for _ in range(8):
        run.run(rng.uniform(0.0, 0.3))
        rng.choice([run.restart_filter, run.restart_plant])()
    run.sent.clear()
    run.run(0.005)

    assert run.seconds_until_sequence(LOST_START_S + 1.0) < float("inf")


def test_what_is_remembered_of_inputs_sent_is_bounded() -> None:
    run = InputSequenceRun(**bad_links(delay_s=0.1, jitter_s=0.05, loss=0.3, seed=1)).run(2.0)
    run.filter.severed = {STATES}
    run.run(3.0)
    predictor, held = run.filter.node._predictor, run.plant.node._inputs._pending

    at_most = (0.5 + 0.2) * RATE_HZ
    assert len(predictor._sent) <= at_most
    assert len(predictor._trajectory) <= at_most
    assert len(held) <= at_most


def logged(path: Path, *, restart: bool, **overrides: object) -> tuple[InputSequenceRun, RunLog]:
    """Run with a log, with another filter halfway if wanted."""
    scenario = load_scenario("notomista-cai-2020", SLOW | overrides)
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as log:
        run = InputSequenceRun(observer=LockstepLog(log), **overrides).run(1.2)
        if restart:
            run.restart_filter(dead_s=0.02)
            run.run(1.3)
    return run, RunLog.read(path)


@pytest.mark.parametrize(("estimator", "restart"), [(0, False), (0, True), (1, True)])
def test_a_log_of_a_bad_network_replays_tick_by_tick(tmp_path: Path, estimator: int, *, restart: bool) -> None:
    overrides = bad_links(delay_s=0.04, jitter_s=0.03, loss=0.2, seed=9) | {"operator.estimator": ESTIMATORS[estimator]}
    run, log = logged(tmp_path / "run.mcap", restart=restart, **overrides)
    steps = [message.header.scheduled_ns for message in log.of(PlantInput)]
    found = replay_filter(log)

    assert found.first_difference == ""
    assert found.exact
    assert found.ticks == len(run.ticks())
    assert len({message.header.epoch for message in log.of(FilterTick)}) == 1 + restart
    assert len(set(steps)) < len(steps)  # several inputs in a step


def test_unpredicted_filter_sends_unsequenced_inputs() -> None:
    run = InputSequenceRun(filter__prediction=False, **bad_links(delay_s=0.05)).run(1.0)
    inputs = [body for _, _, body in run.sent if isinstance(body, PlantInput)]
    states = {state.x for state in run.trajectory()}

    assert {(each.input_sequence_start_ns, each.known_break_ns, each.previous_u) for each in inputs} == {(-1, -1, ())}
    assert {tick.x_hat for tick in run.ticks()} <= states
    assert {tick.horizon_ns for tick in run.ticks()} == {0}
    assert PlantPhase.RUNNING in {state.phase for state in run.trajectory()}
