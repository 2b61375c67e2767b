"""Ages of commands and states of a live system with slow links."""

from pathlib import Path

import numpy as np
import pytest
from passafe_protocol.messages import FilterStatus, FilterTick, OperatorCommand, PlantState
from passafe_services.loop.monotonic_clock import monotonic_clock_id
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.run_log import RunLog
from running_demo import running_demo

pytestmark = pytest.mark.live

SLOW = ("--link", "operator-to-filter:delay=0.35", "--link", "plant-to-filter:delay=0.25,jitter=0.05")


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunLog, str]:
    folder: Path = tmp_path_factory.mktemp("ages")
    with running_demo(folder, "--duration", "4", "--rate", "250", "--headless", *SLOW) as demo:
        demo.end()
    [path] = folder.glob("*.mcap")
    return RunLog.read(path), "".join(demo.lines)


def test_robot_is_not_driven_by_commands_that_are_too_old(slow: tuple[RunLog, str]) -> None:
    log, text = slow
    ticks = [tick.body for tick in log.of(FilterTick)]

    assert {tick.status for tick in ticks} == {FilterStatus.STALE}
    assert {tick.command_state for tick in ticks} <= {"none", "delayed"}
    assert min(tick.command_age_ns for tick in ticks[-250:]) >= 350_000_000
    assert not any(any(tick.u_h) for tick in ticks)
    assert "too old when they arrived" in text
    assert "verdict   holds" not in text


def test_age_of_the_state_is_that_of_its_content(slow: tuple[RunLog, str]) -> None:
    log, _ = slow
    ages_ms = np.array([tick.body.state_age_ns / 1e6 for tick in log.of(FilterTick)][-500:])

    assert 195 <= np.median(ages_ms) <= 320


def test_processes_of_one_host_name_one_clock(slow: tuple[RunLog, str]) -> None:
    log, _ = slow
    clocks = {sent.header.clock_id for kind in (OperatorCommand, PlantState, FilterTick) for sent in log.of(kind)}

    assert clocks == {monotonic_clock_id()}


def test_supervisor_gives_epochs_in_the_order_of_the_starts(slow: tuple[RunLog, str]) -> None:
    log, _ = slow
    started = (OperatorCommand, FilterTick, PlantState)
    sessions = [{sent.header.epoch for sent in log.of(kind)} for kind in started]

    assert [len(epochs) for epochs in sessions] == [1, 1, 1]
    operator, core, plant = (min(epochs) for epochs in sessions)
    assert operator < core < plant


def test_late_commands_replay_to_the_last_bit(slow: tuple[RunLog, str]) -> None:
    result = replay_filter(slow[0])

    assert result.exact, result
