"""Commands and states that are long on the way, in closed loop."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import Event, FilterStatus, FilterTick, Header, Message, PlantState
from passafe_protocol.topics import Topic
from passafe_services.filter.build import filter_node
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.loop.lockstep import Lockstep
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.run_log import RunLog

MS = 1_000_000
LINK = "operator-to-filter"


class Run(NamedTuple):
    """Messages of a run: ticks with their times, positions of the robot, and the filter's events."""

    due_s: np.ndarray
    ticks: list[FilterTick]
    x_m: np.ndarray
    events: list[str]

    def between(self, begin_s: float, end_s: float) -> list[FilterTick]:
        return [tick for due_s, tick in zip(self.due_s, self.ticks, strict=True) if begin_s <= due_s < end_s]


def scenario_of(points: list[tuple[float, float]], **overrides: object) -> Scenario:
    source = {"kind": "waypoints", "points": [{"at_s": t, "value": [u, 0.0]} for t, u in points]}
    values = {key.replace("__", "."): value for key, value in overrides.items()}
    base = {"rate_hz": 250.0, "operator.source": source, "filter.feedback": {"k_d": 4.0}}
    return load_scenario("walls-and-disks", base | values)


def run_of(scenario: Scenario) -> Run:
    due_s, ticks, x_m, events = [], [], [], []

    def keep(_topic: Topic, header: Header, body: Message) -> None:
        if isinstance(body, FilterTick):
            due_s.append((header.scheduled_ns - 1_000 * MS) / 1e9)
            ticks.append(body)
        elif isinstance(body, PlantState):
            x_m.append(body.x[0])
        elif isinstance(body, Event) and header.source == "filter":
            events.append(body.text)

    lockstep_loop(scenario, keep).run(steps_of(scenario))
    return Run(np.array(due_s), ticks, np.array(x_m), events)


LETS_GO = [(0.0, 2.0), (1.5, 2.0), (1.51, 0.0)]


@pytest.mark.parametrize("prediction", [True, False])
def test_robot_rests_though_old_commands_arrive(*, prediction: bool) -> None:
    """The link lags by 2 s from 0.7 s on; the operator lets go at 1.5 s, and earlier commands come until 3.5 s."""
    change = {"at_s": 0.7, "link": LINK, "settings": {"delay_s": 2.0}}
    run = run_of(scenario_of(LETS_GO, duration_s=4.5, link_changes=[change], filter__prediction=prediction))

    late = run.between(2.7, 4.5)
    assert {tick.command_state for tick in late} == {"delayed"}
    assert {tick.u_h for tick in late} == {(0.0, 0.0)}
    assert all(tick.command_age_ns == 2_000 * MS for tick in late[1:])
    assert abs(run.x_m[-1] - run.x_m[round(2.7 * 250)]) < 0.01
    assert "commands are 2000 ms old when they arrive, allowed 200 ms: they do not count" in run.events


def test_link_slower_than_the_limit_never_drives() -> None:
    run = run_of(scenario_of([(0.0, 5.0), (9.0, 5.0)], duration_s=1.0, links={LINK: {"delay_s": 0.25}}))

    assert np.ptp(run.x_m) == 0.0
    assert {tick.status for tick in run.ticks} == {FilterStatus.STALE}
    assert {tick.command_state for tick in run.ticks} == {"none", "delayed"}


def test_delay_below_the_limit_only_delays() -> None:
    slow = {LINK: {"delay_s": 0.18}}
    run = run_of(scenario_of([(0.0, 2.0), (9.0, 2.0)], duration_s=1.0, links=slow))
    ages = [tick.command_age_ns for tick in run.between(0.2, 1.0)]

    assert {tick.command_state for tick in run.between(0.2, 1.0)} == {"counts"}
    assert {tick.u_h for tick in run.between(0.2, 1.0)} == {(2.0, 0.0)}
    assert set(ages) == {180 * MS}


def test_link_that_recovers_replays_nothing_and_ramps_in() -> None:
    """The command changes its sign while the link lags by 1.5 s; the backlog asks for the old one."""
    points = [(0.0, 3.0), (1.0, 3.0), (1.01, -3.0), (9.0, -3.0)]
    changes = [
        {"at_s": 0.5, "link": LINK, "settings": {"delay_s": 1.5}},
        {"at_s": 1.9, "link": LINK, "settings": {"delay_s": 0.01}},
    ]
    run = run_of(scenario_of(points, duration_s=3.5, link_changes=changes))

    resumed = run.between(1.9, 3.5)
    u_h = np.array([tick.u_h[0] for tick in resumed])
    assert u_h.max() == 0.0
    assert u_h[-1] == -3.0
    assert np.abs(np.diff(u_h)).max() <= 3.0 * 0.004 / 0.5 + 1e-9
    ramp = [tick.command_share for tick in resumed if tick.command_state == "resumes"]
    assert len(ramp) == 125
    assert np.diff(ramp) == pytest.approx(0.008)
    assert "commands count again: they ramp in within 0.5 s" in run.events


def test_age_of_the_state_includes_its_way() -> None:
    link = {"delay_s": 0.25, "jitter_s": 0.05, "distribution": "uniform", "seed": 3}
    scenario = scenario_of([(0.0, 1.0), (9.0, 1.0)], duration_s=3.0, links={"plant-to-filter": link})
    ages_ms = np.array([tick.state_age_ns / MS for tick in run_of(scenario).between(1.0, 3.0)])

    assert ages_ms.min() >= 195
    assert ages_ms.max() <= 305
    assert np.median(ages_ms) == pytest.approx(250, abs=55)


@pytest.mark.parametrize("prediction", [True, False])
def test_stale_stretches_replay_bit_for_bit(tmp_path: Path, *, prediction: bool) -> None:
    changes = [
        {"at_s": 0.4, "link": LINK, "settings": {"loss": 1.0}},
        {"at_s": 0.8, "link": LINK, "settings": {"delay_s": 0.05, "jitter_s": 0.02, "loss": 0.2, "seed": 5}},
        {"at_s": 1.2, "link": LINK, "settings": {"delay_s": 0.3}},
        {"at_s": 1.6, "link": LINK, "settings": {"delay_s": 0.0}},
    ]
    estimator = {"kind": "white-acceleration", "agility": 50.0, "resolution": 0.05}
    scenario = scenario_of(
        [(0.0, 1.0), (9.0, 1.0)],
        duration_s=2.0,
        link_changes=changes,
        filter__prediction=prediction,
        operator__estimator=estimator,
    )
    path = tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        lockstep_loop(scenario, LockstepLog(writer)).run(steps_of(scenario))
    log = RunLog.read(path)

    states = {tick.body.command_state for tick in log.of(FilterTick)}
    assert states == {"counts", "silent", "resumes", "delayed"}
    assert replay_filter(log).exact


@pytest.mark.parametrize(("delay_s", "drives"), [(0.25, False), (0.15, True)])
def test_operator_on_another_host_is_held_to_the_limit(*, delay_s: float, drives: bool) -> None:
    """No clock is shared; the delay is there from the first message on, and only an echo shows it."""
    points = [(0.0, 5.0), (9.0, 5.0)]
    scenario = scenario_of(points, duration_s=1.0, filter__feedback={"k_d": 4.0})
    ticks: list[FilterTick] = []

    def keep(_topic: Topic, _header: Header, body: Message) -> None:
        if isinstance(body, FilterTick):
            ticks.append(body)

    nodes = [plant_node(scenario), operator_node(scenario, 1), filter_node(scenario, "lockstep", 1, clock_id=77)]
    loop = Lockstep(nodes, period_ns=4 * MS, links={LINK: LinkSettings(delay_s=delay_s)}, observer=keep)
    loop.run(250)

    assert {tick.command_state for tick in ticks} == {"none", "counts" if drives else "delayed"}
    assert ticks[-1].command_age_ns == pytest.approx(delay_s * 1e9, abs=8 * MS)
    assert ticks[-1].u_h == ((5.0, 0.0) if drives else (0.0, 0.0))
