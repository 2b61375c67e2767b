"""Measures how many times real time ``passafe replay`` runs on one core, beside the loop that it repeats.

``python benchmarks/replay_speed.py``. A log is recorded in virtual time; then its replay and the loop itself, with
nothing recorded, take turns. Processor time: a loaded machine makes both slower alike. The stages are timed in a run of
their own.
"""

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import process_time_ns
from typing import Annotated, TypeVar

import typer
from lockstep_speed import loop_nodes, use_one_core, warm_loop
from passafe_services.log.log_pass import LogPass
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.replay.filter_replay import WANTS, FilterReplay, Replay
from passafe_services.tools.replay.replay_log import replay_file
from passafe_services.tools.review.run_review import identity_of
from report import AsJson, Ratio, Report, Smallest, spread
from timing import in_turn

T = TypeVar("T")


def main(
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    rounds: Annotated[int, typer.Option(min=1, max=100, help="Timed replays.")] = 5,
    periods: Annotated[int, typer.Option(min=10, help="Periods of the log.")] = 30_000,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time the replay of a log and the loop that it is of."""
    if smallest:
        rounds, periods = 1, 200
    use_one_core()
    loaded = load_scenario(scenario, {})
    report = Report(
        title=f"Replay, {scenario}, {rounds} replays of {periods} ticks",
        columns=("what", "µs a tick", "× real time"),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        record(path, loaded, periods)
        replays, loops = in_turn([partial(replay_us, path), partial(loop_us, loaded, periods)], rounds)
        real_us = period_ns(loaded) / 1e3
        for name, each in (("replay, the log's scenario built", replays), ("the loop, not recorded", loops)):
            report.rows.append((name, spread(each), spread([real_us / one for one in each])))
        for name, us in stages_us(path).items():
            report.rows.append((f"… {name}", f"{us:.1f}", ""))
        if not replay_file(path).exact:
            report.failures.append("replay: a tick differs")
    report.ratios.append(Ratio.of_rounds("replay of a tick", replays, "period of the loop", loops))
    report.finish(as_json=as_json)


def record(path: Path, scenario: Scenario, periods: int) -> None:
    """Write the log of a run in virtual time."""
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        lockstep_loop(scenario, LockstepLog(writer)).run(periods)


def replay_us(path: Path) -> float:
    """Return what a replay takes from the reading of the log on, the build of its filter left out, µs a tick."""
    log = LogPass(path, workers=0)
    replay = FilterReplay(identity_of(log))
    result, us = timed_us(partial(replayed, replay, log))
    return us / result.ticks


def replayed(replay: FilterReplay, log: LogPass) -> Replay:
    """Return the result of a replay of a log."""
    for part in log.slices(WANTS, wanted_only=True):
        replay.take(part)
    return replay.end()


def loop_us(scenario: Scenario, periods: int) -> float:
    """Return what the loop takes that nobody records, µs a period."""
    loop = warm_loop(loop_nodes(scenario), scenario)
    return timed_us(partial(loop.run, periods))[1] / periods


def stages_us(path: Path) -> dict[str, float]:
    """Return what the stages of a replay take, µs a tick."""
    log = LogPass(path, workers=0)
    replay = FilterReplay(identity_of(log))
    spent = dict.fromkeys(("read and decode", "step and compare"), 0.0)
    slices: Iterator[object] = log.slices(WANTS, wanted_only=True)
    while True:
        part, us = timed_us(partial(next, slices, None))
        spent["read and decode"] += us
        if part is None:
            break
        spent["step and compare"] += timed_us(partial(replay.take, part))[1]
    ticks = replay.end().ticks
    return {name: us / ticks for name, us in spent.items()}


def timed_us(call: Callable[[], T]) -> tuple[T, float]:
    """Return the result of a call and its processor time, µs."""
    begin = process_time_ns()
    result = call()
    return result, (process_time_ns() - begin) / 1e3


if __name__ == "__main__":
    typer.run(main)
