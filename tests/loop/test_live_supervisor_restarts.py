"""Processes that a supervisor restarts."""

import asyncio
import json
import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest
from passafe_services.loop.child_process import ChildProcess
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy
from passafe_services.loop.supervisor import supervise
from supervised_toys import PATIENCE_S, Terminal, gone, toy

pytestmark = pytest.mark.live
only_root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root may raise priorities")


def test_dead_process_is_restarted_while_the_others_run_on(terminal: Terminal) -> None:
    def stop_when_back(name: str, _pid: int) -> None:
        if [output for output, _ in terminal.said_pid].count(name) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    terminal.on_pid = stop_when_back
    outcome = supervise(
        [toy("router"), toy("filter", restarts=RestartPolicy()), toy("plant")],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.restarts == {"filter": 1}
    assert terminal.texts.count("filter died: killed by SIGKILL; restarted") == 1
    assert [name for name, _ in terminal.said_pid] == ["router", "filter", "plant", "filter"]
    assert [end.name for end in outcome.exits] == ["filter", "plant", "filter", "router"]  # in its old place
    assert gone([pid for _, pid in terminal.said_pid])


@only_root
def test_one_that_is_started_is_preferred_until_it_is_ready(terminal: Terminal) -> None:
    """The toy says its pid before it is ready."""
    own = os.getpriority(os.PRIO_PROCESS, 0)
    preferred: list[bool] = []

    def look(_name: str, pid: int) -> None:
        preferred.append(os.getpriority(os.PRIO_PROCESS, pid) < own)
        if len(preferred) == 2:
            threading.Thread(target=stop_when_ordinary, args=(pid,)).start()

    def stop_when_ordinary(pid: int) -> None:
        end = time.monotonic() + PATIENCE_S
        while os.getpriority(os.PRIO_PROCESS, pid) != own and time.monotonic() < end:
            time.sleep(0.01)
        preferred.append(os.getpriority(os.PRIO_PROCESS, pid) < own)
        os.kill(os.getpid(), signal.SIGINT)

    terminal.on_pid = look
    supervise(
        [toy("filter", restarts=RestartPolicy())],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert preferred == [True, True, False]


@only_root
def test_niceness_that_a_process_chose_itself_remains() -> None:
    chosen = os.getpriority(os.PRIO_PROCESS, 0) - 3

    async def niceness_when_ready() -> int:
        pids: list[int] = []

        def choose(_name: str, text: str) -> None:
            """Choose in place of the toy, which says its pid before it is ready."""
            if text.startswith("{"):
                pids.append(json.loads(text)["pid"])
                os.setpriority(os.PRIO_PROCESS, pids[0], chosen)

        child = await ChildProcess.start(toy("page"), choose)
        child.prioritize_startup()
        try:
            await asyncio.wait_for(child.ready.wait(), PATIENCE_S)
            return os.getpriority(os.PRIO_PROCESS, pids[0])
        finally:
            child.kill()
            await child.ended

    assert asyncio.run(niceness_when_ready()) == chosen


def test_one_that_dies_too_often_ends_the_run(terminal: Terminal) -> None:
    def kill(name: str, pid: int) -> None:
        if name == "filter" and terminal.texts.count("all are ready"):
            os.kill(pid, signal.SIGKILL)

    def begin() -> None:
        terminal("all are ready")
        kill("filter", terminal.pids["filter"]["pid"])

    terminal.on_pid = kill
    filter_spec = toy("filter", restarts=RestartPolicy(most=2, within_s=600.0))
    outcome = supervise([toy("plant"), filter_spec], emit=terminal, on_ready=begin)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "filter")
    assert outcome.detail == "filter died: killed by SIGKILL"
    assert outcome.restarts == {"filter": 2}
    assert not outcome.clean
    assert gone([pid for _, pid in terminal.said_pid])


def test_deaths_long_ago_do_not_count(terminal: Terminal) -> None:
    """With a stretch of no length none ever does, so the fourth death is like the first."""

    def kill(_name: str, pid: int) -> None:
        if len(terminal.said_pid) <= 4:
            os.kill(pid, signal.SIGKILL)
        else:
            os.kill(os.getpid(), signal.SIGTERM)

    def begin() -> None:
        kill(*terminal.said_pid[0])
        terminal.on_pid = kill

    outcome = supervise([toy("filter", restarts=RestartPolicy(most=1, within_s=0.0))], emit=terminal, on_ready=begin)
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.restarts == {"filter": 4}


def test_a_process_that_leaves_is_not_started_again(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("operator", "brief", restarts=RestartPolicy())], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.LEFT, "operator")
    assert outcome.restarts == {}


def test_death_that_ends_the_run_is_not_masked_by_a_restart(terminal: Terminal) -> None:
    def kill() -> None:
        for name in ("filter", "plant"):
            os.kill(terminal.pids[name]["pid"], signal.SIGKILL)
        time.sleep(0.2)  # holds up the supervisor itself, so that it finds both ends at once

    outcome = supervise([toy("filter", restarts=RestartPolicy()), toy("plant")], emit=terminal, on_ready=kill)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "plant")
    assert gone(terminal.all_pids)


def test_duration_includes_the_time_of_restarts(terminal: Terminal) -> None:
    outcome = supervise(
        [toy("filter", restarts=RestartPolicy())],
        duration_s=3.0,
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.DURATION
    assert outcome.restarts == {"filter": 1}
    assert outcome.clean
    assert gone([pid for _, pid in terminal.said_pid])


def test_restarted_process_that_is_not_ready_is_killed_and_named(terminal: Terminal, tmp_path: Path) -> None:
    """The toy is ready the first time only: later it finds its mark."""
    code = (
        "import json, os, pathlib, sys, time; from passafe_services.loop.readiness import announce_ready; "
        "mark = pathlib.Path(sys.argv[1]); again = mark.exists(); mark.touch(); "
        "again or print(json.dumps({'pid': os.getpid()}), flush=True); again or announce_ready('filter'); "
        "time.sleep(60)"
    )
    spec = ProcessSpec(
        name="filter",
        argv=(sys.executable, "-c", code, str(tmp_path / "mark")),
        restarts=RestartPolicy(most=2, within_s=600.0),
    )
    outcome = supervise(
        [spec],
        emit=terminal,
        ready_timeout_s=5.0,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.DIED
    assert outcome.restarts == {"filter": 2}
    assert terminal.texts[1:] == [
        "filter died: killed by SIGKILL; restarted",
        "filter was not ready within 5 s: killed",
        "filter died: killed by SIGKILL; restarted",
        "filter was not ready within 5 s: killed",
        "filter died: killed by SIGKILL",
    ]
