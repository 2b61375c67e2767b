"""A session of runs: what stays, what is replaced, and what ends all."""

import asyncio
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from passafe_services.loop.process_exit import ExitCause, RunOutcome
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy
from passafe_services.loop.supervision import Supervision
from passafe_services.loop.supervisor import supervised
from passafe_services.session.planned_run import PlannedRun
from toy_runs import Script, press_ctrl_c, toy, toy_run

pytestmark = pytest.mark.live

MISSING = ProcessSpec(name="plant", argv=("/nonexistent/program",))


def play(script: Script) -> tuple[RunOutcome, list[str]]:
    """Run a session to its end; return it with the lines that were printed."""
    lines: list[str] = []

    async def run(supervision: Supervision) -> RunOutcome:
        end = await script.session.run(supervision)
        await supervision.stop()
        return RunOutcome(cause=end.cause, culprit=end.culprit, detail=end.detail, exits=supervision.take_exits())

    return supervised(run, emit=lines.append, on_change=script.session.on_change), lines


def when(condition: Callable[[], bool], act: Callable[[], object]) -> Callable[[], None]:
    """Return a listener that acts once, at the first change after which the condition holds."""
    acted: list[bool] = []

    def listen() -> None:
        if not acted and condition():
            acted.append(True)
            act()

    return listen


def test_run_follows_run_while_the_router_stays() -> None:
    script = Script(toy_run("filter", "plant"))
    script.on_ready = lambda number: script.session.start(toy_run("plant")) if number == 1 else press_ctrl_c()

    end, lines = play(script)

    assert script.ready_runs == [1, 2]
    assert [outcome.cause for outcome in script.outcomes] == [ExitCause.REQUESTED, ExitCause.SIGNAL]
    assert [[one.name for one in outcome.exits] for outcome in script.outcomes] == [["plant", "filter"], ["plant"]]
    assert [one.name for one in end.exits] == ["router"]
    assert end.clean
    assert not any("died" in line for line in lines)


def test_run_that_is_ended_leaves_a_session_that_waits() -> None:
    script = Script(toy_run("plant", log="runs/first.mcap"))
    session = script.session
    script.on_ready = lambda number: session.end() if number == 1 else press_ctrl_c()
    waiting = []

    def start_again() -> None:
        waiting.append((session.state, session.end()))
        session.start(toy_run("plant"))

    session.on_change = when(lambda: session.phase == "stopped", start_again)
    end, _ = play(script)

    [(state, may_end)] = waiting
    assert not may_end
    assert (state.state, state.run, state.recording) == ("stopped", 1, False)
    assert state.last is not None
    assert (state.last.run, state.last.log, state.last.detail) == (1, "first.mcap", "ended on request")
    assert script.ready_runs == [1, 2]
    assert end.cause is ExitCause.SIGNAL


def test_newest_of_runs_requested_while_one_stops_wins() -> None:
    script = Script(toy_run("plant"))
    session = script.session
    script.on_ready = lambda number: session.start(toy_run("one")) if number == 1 else press_ctrl_c()

    def change_mind(number: int) -> None:
        if number == 1:
            assert session.phase == "stopping"
            session.start(toy_run("two"))
            session.start(toy_run("three"))

    script.on_ended = change_mind
    play(script)

    assert session.present.choices.scenario == "three"
    assert script.ready_runs == [1, 2]


def test_run_requested_while_another_starts_takes_its_place() -> None:
    slow = ProcessSpec(name="filter", argv=toy("other").argv)  # never says that it is ready
    script = Script(toy_run("plant"))
    session = script.session
    script.on_ready = lambda number: (
        session.start(toy_run(specs=(toy("operator"), slow))) if number == 1 else press_ctrl_c()
    )
    session.on_change = when(
        lambda: session.phase == "starting" and "filter" in session.state.processes,
        lambda: session.start(toy_run("plant")),
    )
    play(script)

    assert script.ready_runs == [1, 3]
    assert script.began == [True, False, True]
    assert script.outcomes[1].cause is ExitCause.REQUESTED
    assert script.outcomes[1].clean


def test_requested_run_that_cannot_start_is_reported() -> None:
    script = Script(toy_run("plant"))
    session = script.session
    script.on_ready = lambda _number: session.start(toy_run(specs=(toy("filter"), MISSING)))
    session.on_change = when(lambda: session.phase == "stopped", press_ctrl_c)

    end, _ = play(script)

    assert end.cause is ExitCause.SIGNAL
    assert script.outcomes[1].cause is ExitCause.NOT_STARTED
    assert not script.outcomes[1].clean
    assert "plant cannot be started" in session.state.trouble


def test_first_run_that_cannot_start_ends_all() -> None:
    end, _ = play(Script(toy_run(specs=(MISSING,))))

    assert (end.cause, end.culprit) == (ExitCause.NOT_STARTED, "plant")
    assert [one.name for one in end.exits] == ["router"]


def test_run_that_is_not_started_leaves_no_file(tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("replaced.json", "ended.json", "left.json")]
    runs = [replace(toy_run("plant"), scenario_file=file) for file in files]
    for file in files:
        file.touch()
    script = Script(toy_run("plant"))
    session = script.session

    def change_mind(number: int) -> None:
        if number == 1:
            session.start(runs[0])
            session.start(runs[1])
            session.end()
            session.start(runs[2])
            press_ctrl_c()

    script.on_ready = change_mind
    play(script)

    assert session.wanted is None
    assert list(tmp_path.iterdir()) == []


def pid_of(script: Script, name: str) -> int:
    """Return the process id of a process, 0 while there is none."""
    supervision = script.session._supervision
    child = None if supervision is None else supervision._child(name)
    return 0 if child is None or child._transport is None else child._transport.get_pid()


def kill_named(script: Script, name: str) -> None:
    os.kill(pid_of(script, name), signal.SIGKILL)


@pytest.mark.parametrize("victim", ["plant", "router"])
def test_process_that_dies_ends_all(victim: str) -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: kill_named(script, victim)

    end, _ = play(script)

    assert (end.cause, end.culprit) == (ExitCause.DIED, victim)
    assert not (end.clean and script.outcomes[0].clean)


def test_router_that_dies_in_a_change_ends_all() -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: script.session.start(toy_run("plant"))
    script.on_ended = lambda number: kill_named(script, "router") if number == 1 else None

    end, _ = play(script)

    assert (end.cause, end.culprit) == (ExitCause.DIED, "router")


def test_router_with_a_policy_is_restarted_in_a_change() -> None:
    script = Script(toy_run("plant"), toy("router", restarts=RestartPolicy()))
    session, killed = script.session, []

    def kill(number: int) -> None:
        if number == 1:
            killed.append(pid_of(script, "router"))
            kill_named(script, "router")

    def is_back() -> bool:
        """Check for another router; on a busy machine the next run may be ready before its end is noticed."""
        running = session.state.processes["router"].state == "running"
        return script.ready_runs == [1, 2] and running and pid_of(script, "router") not in {0, *killed}

    end_when_back = when(is_back, press_ctrl_c)
    script.on_ready = lambda number: session.start(toy_run("plant")) if number == 1 else end_when_back()
    script.on_ended = kill
    session.on_change = end_when_back

    end, lines = play(script)

    assert end.cause is ExitCause.SIGNAL
    assert "router died: killed by SIGKILL; restarted" in lines
    assert script.ready_runs == [1, 2]


def test_ctrl_c_in_a_change_starts_no_other_run() -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: script.session.start(toy_run("plant"))
    script.on_ended = lambda number: press_ctrl_c() if number == 1 else None

    end, _ = play(script)

    assert script.ready_runs == [1]
    assert end.cause is ExitCause.SIGNAL
    assert end.clean


def test_killed_process_stays_down_until_its_restart() -> None:
    script = Script(toy_run("filter", "plant"))
    session, name = script.session, ProcessName.FILTER
    seen = []
    script.on_ready = lambda _number: session.kill(name)

    def restart() -> None:
        seen.append((session.permitted(name), session.kill(name)))
        session.restart(name)

    down = when(lambda: session.state.processes["filter"].state == "down", restart)
    back = when(lambda: bool(seen) and session.state.processes["filter"].state == "running", press_ctrl_c)

    def listen() -> None:
        if "filter" in session.state.processes:
            down()
            back()

    session.on_change = listen
    end, lines = play(script)

    assert seen == [(("restart",), False)]
    assert "filter restarted on request" in lines
    [outcome] = script.outcomes
    assert outcome.clean
    assert outcome.killed_on_request == {"filter": 1}
    assert outcome.restarts == {"filter": 1}
    assert end.clean


def test_permission_for_a_process_depends_on_which_it_is() -> None:
    script = Script(toy_run("recorder", "plant"), toy("router"), toy("dashboard"), toy("awake-0"))
    session = script.session
    names = ("router", "dashboard", "recorder", "plant", "awake-0", "filter")
    found = {}

    def look(_number: int) -> None:
        found.update({name: session.permitted(name) for name in names})
        press_ctrl_c()

    script.on_ready = look
    script.on_ended = lambda _number: found.update(stopping=session.permitted("router"))
    play(script)

    both = ("kill", "restart")
    assert found == {
        "router": both,
        "dashboard": (),
        "recorder": ("kill",),
        "plant": both,
        "awake-0": (),
        "filter": (),
        "stopping": (),
    }


def test_verdict_of_the_run_before_is_shown_but_no_older_one() -> None:
    script = Script(toy_run("plant"))
    session = script.session

    def conclude(number: int) -> None:
        if number == 1:
            session.start(toy_run("plant"))
        else:
            script.conclusions[1]("holds", "holds")
            assert session.state.last is not None
            assert session.state.last.words == "holds"
            press_ctrl_c()

    script.on_ready = conclude
    play(script)
    script.conclusions[1]("violated", "too late")

    assert session.state.last is not None
    assert (session.state.last.run, session.state.last.outcome) == (2, "")


def test_request_before_the_session_runs_is_kept() -> None:
    session = Script(toy_run("plant")).session

    assert not session.kill(ProcessName.PLANT)
    assert not session.restart(ProcessName.PLANT)
    assert session.state.processes == {}
    assert asyncio.iscoroutinefunction(session.run)
    run: PlannedRun = toy_run("plant")
    session.start(run)
    assert session.wanted is run
