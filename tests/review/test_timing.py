"""Lateness, ages and latencies from headers that are known."""

from pathlib import Path

import numpy as np
import pytest
from damped_point_run import PERIOD_NS, Run, header, rollout, tick
from msgspec.structs import replace
from passafe_protocol.messages import FilterTick, OperatorCommand, PlantInput, PlantState
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.timing import Percentiles, Timing, TimingRecord

US = 1_000
STEPS = 101


def run_with_times(driver: str = "live") -> Run:
    """Filter step k begins k µs late and takes 20 µs; a command is 10·k µs old; the plant 3 ms late."""
    run = Run(driver=driver)
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: (0.0, 0.0), steps=STEPS)
    for index, (head, body) in enumerate(run.sent):
        k = head.sequence
        late_ns = {OperatorCommand: 5 * US, PlantState: 3000 * US}.get(type(body), k * US)
        begun_ns = head.scheduled_ns + late_ns
        sent_ns = begun_ns + 20 * US
        wall_ns = head.wall_ns + late_ns + 20 * US
        moved = replace(head, started_ns=begun_ns, sent_ns=sent_ns, wall_ns=wall_ns)
        run.sent[index] = (moved, body)
    for k, index in enumerate(run.indices(FilterTick)):
        run.replace(index, command_age_ns=k * 10 * US)
    return run


def read(run: Run, tmp_path: Path) -> RunLog:
    return RunLog.read(run.write(tmp_path / "run.mcap"))


def test_lateness_of_every_process(tmp_path: Path) -> None:
    late = Timing.of(read(run_with_times(), tmp_path)).late_us
    assert late is not None
    assert late["filter"].p50 == pytest.approx(50)
    assert late["filter"].p99 == pytest.approx(99)
    assert late["filter"].max == pytest.approx(100)
    assert late["filter"].within_1_ms == 1.0
    assert late["operator"].p99_9 == pytest.approx(5)
    assert late["plant"].p50 == pytest.approx(3000)
    assert late["plant"].within_1_ms == 0.0


def test_solve_time_is_the_filter_step_up_to_its_input(tmp_path: Path) -> None:
    run = run_with_times()
    for index in run.indices(FilterTick):  # telemetry is sent after the input and does not count
        head, body = run.sent[index]
        run.sent[index] = (replace(head, sent_ns=head.sent_ns + 500 * US), body)
    solve = Timing.of(read(run, tmp_path)).solve_us
    assert solve == Percentiles(p50=20, p99=20, p99_9=20, max=20)


def test_command_age_leaves_out_ticks_before_the_first_command(tmp_path: Path) -> None:
    run = run_with_times()
    first, *_ = run.indices(FilterTick)
    run.replace(first, command_age_ns=-1)
    age = Timing.of(read(run, tmp_path)).command_age_ms
    assert age is not None
    assert age.p50 == pytest.approx(np.percentile(np.arange(1, STEPS) / 100, 50))
    assert age.max == pytest.approx(1.0)


def test_ages_of_states_are_those_of_the_ticks(tmp_path: Path) -> None:
    run = run_with_times()
    for index in run.indices(FilterTick):
        run.replace(index, state_age_ns=250_000 * US)
    age = Timing.of(read(run, tmp_path)).state_age_ms
    assert age == Percentiles(p50=250, p99=250, p99_9=250, max=250)


def test_operator_to_plant_latency_ends_at_application(tmp_path: Path) -> None:
    # Command k is sent 25 µs after its step was due; the input made from it is applied by the plant step that
    # began 3 ms after the same time.
    latency = Timing.of(read(run_with_times(), tmp_path)).operator_to_plant_ms
    assert latency is not None
    assert latency.p50 == pytest.approx(3.0 - 0.025)
    late = run_with_times()
    for index in late.indices(PlantState):
        body = late.sent[index][1]
        assert isinstance(body, PlantState)
        late.replace(index, applied_tick=max(body.applied_tick - 2, 0))  # two periods later
    assert Timing.of(read(late, tmp_path)).operator_to_plant_ms == pytest.approx(
        Percentiles(p50=4.975, p99=4.975, p99_9=4.975, max=4.975), abs=1e-9
    )


def test_latency_is_unknown_after_a_filter_restart(tmp_path: Path) -> None:
    run = run_with_times()
    run.add(header("filter", 0, epoch=2), tick(0, (0.0, 0.0)))
    assert Timing.of(read(run, tmp_path)).operator_to_plant_ms is None


def test_latency_between_two_clocks_is_unknown(tmp_path: Path) -> None:
    run = run_with_times()
    for index in run.indices(PlantState):
        head, body = run.sent[index]
        run.sent[index] = (replace(head, clock_id=7, wall_ns=head.wall_ns + 3_600 * 10**9), body)

    assert Timing.of(read(run, tmp_path)).operator_to_plant_ms is None


def test_nothing_is_made_up_for_lockstep(tmp_path: Path) -> None:
    timing = Timing.of(read(run_with_times("lockstep"), tmp_path))
    assert timing.solve_us is None
    assert timing.late_us is None
    assert timing.command_age_ms is not None  # virtual time ages commands too


def test_nothing_is_made_up_without_messages(tmp_path: Path) -> None:
    timing = Timing.of(read(Run(), tmp_path))
    assert (timing.solve_us, timing.command_age_ms, timing.operator_to_plant_ms) == (None, None, None)
    assert timing.late_us == {}


@pytest.mark.parametrize(
    ("logged", "skipped"),
    [
        ([(k, k) for k in range(5)], 0),
        ([(0, 0), (1, 3), (2, 4)], 2),
        ([(0, 0), (3, 3), (4, 4)], 0),  # two that are not logged
    ],
)
def test_skipped_steps_are_gaps_in_the_schedule_not_in_the_log(
    logged: list[tuple[int, int]], skipped: int, tmp_path: Path
) -> None:
    run = Run()
    for sequence, step in logged:
        run.add(header("filter", sequence, step=step), tick(sequence, (0.0, 0.0)))
    log = read(run, tmp_path)
    record = TimingRecord(is_live=True, period_ns=PERIOD_NS)
    for part in log.slices(record.wants):
        record.take(part)
    assert record.steps_skipped == skipped


def test_inputs_alone_are_enough_for_the_solve_time(tmp_path: Path) -> None:
    run = Run()
    head = replace(header("filter", 0), sent_ns=42 * US)
    run.add(head, PlantInput(1, (0.0, 0.0), 0, PERIOD_NS))
    assert Timing.of(read(run, tmp_path)).solve_us == Percentiles(p50=42, p99=42, p99_9=42, max=42)
