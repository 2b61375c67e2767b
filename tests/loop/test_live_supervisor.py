"""The supervisor and real processes: starts, stops, signals, deaths."""

import os
import signal
import threading
import time

import pytest
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.supervisor import supervise
from supervised_toys import PATIENCE_S, Terminal, gone, toy

pytestmark = pytest.mark.live


def test_processes_start_in_order_and_stop_in_the_opposite_order(terminal: Terminal) -> None:
    sessions = {}

    def look() -> None:
        terminal("all are ready")
        sessions.update({output["pid"]: os.getsid(output["pid"]) for output in terminal.pids.values()})

    specs = [toy("first"), toy("second"), toy("third")]
    outcome = supervise(specs, duration_s=0.0, emit=terminal, on_ready=look)
    assert outcome.cause is ExitCause.DURATION
    assert outcome.clean
    assert [end.name for end in outcome.exits] == ["third", "second", "first"]
    assert list(terminal.pids) == ["first", "second", "third"]
    assert len(sessions) == 3
    assert 'first  | {"stopped": "first"}' in terminal.texts
    assert "second | to standard error" in terminal.texts
    assert all(pid == session for pid, session in sessions.items())  # out of reach of a terminal's Ctrl-C
    assert not any("passafe-ready" in line for line in terminal.texts)
    assert gone(terminal.all_pids)


def test_killed_process_is_named_and_nothing_is_left(terminal: Terminal) -> None:
    killed_at = []

    def kill() -> None:
        killed_at.append(time.monotonic())
        os.kill(terminal.pids["plant"]["pid"], signal.SIGKILL)

    outcome = supervise([toy("router"), toy("plant"), toy("filter")], emit=terminal, on_ready=kill)
    assert outcome.cause is ExitCause.DIED
    assert outcome.culprit == "plant"
    assert outcome.detail == "plant died: killed by SIGKILL"
    assert [end.name for end in outcome.died] == ["plant"]
    assert [(end.name, end.returncode) for end in outcome.exits] == [
        ("plant", -9),
        ("filter", 0),
        ("router", 0),
    ]
    assert not outcome.clean
    assert terminal.when("plant died") - killed_at[0] < 1.0
    assert gone(terminal.all_pids)


def test_a_process_that_fails_is_named_with_its_exit_code(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("filter", "brief", "--code", 3)], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "filter")
    assert outcome.detail == "filter died: exit code 3"
    assert gone(terminal.all_pids)


def test_a_process_that_leaves_ends_the_run_cleanly(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("operator", "brief")], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.LEFT, "operator")
    assert outcome.clean
    assert outcome.died == ()


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_one_signal_stops_all_cleanly(terminal: Terminal, signum: int) -> None:
    outcome = supervise([toy("plant"), toy("filter")], emit=terminal, on_ready=lambda: os.kill(os.getpid(), signum))
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.detail == f"stopped by {signal.Signals(signum).name}"
    assert outcome.clean
    assert gone(terminal.all_pids)


def test_a_second_signal_kills_at_once(terminal: Terminal) -> None:
    def interrupt_twice() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()

    began = time.monotonic()
    outcome = supervise(
        [toy("plant"), toy("filter", "stubborn", grace_s=60.0)], emit=terminal, on_ready=interrupt_twice
    )
    assert time.monotonic() - began < PATIENCE_S
    assert outcome.cause is ExitCause.SIGNAL
    assert all(end.killed and end.returncode == -signal.SIGKILL for end in outcome.exits)
    assert gone(terminal.all_pids)


def test_process_ignoring_sigterm_is_killed_with_its_children(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("filter", "stubborn", grace_s=0.2)], duration_s=0.0, emit=terminal)
    assert outcome.cause is ExitCause.DURATION
    assert not outcome.clean
    assert [(end.name, end.killed) for end in outcome.exits] == [("filter", True), ("plant", False)]
    assert "filter was killed: it did not end in 0.2 s" in terminal.texts
    assert set(terminal.pids["filter"]) == {"pid", "child"}
    assert gone(terminal.all_pids)


def test_what_a_killed_process_started_does_not_stay_behind(terminal: Terminal) -> None:
    outcome = supervise(
        [toy("filter", "stubborn")],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.detail == "filter died: killed by SIGKILL"
    assert gone(terminal.all_pids)
