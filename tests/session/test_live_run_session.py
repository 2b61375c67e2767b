"""A session of runs: what stays, what is replaced, and what ends all."""

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.session.planned_run import PlannedRun
from played_sessions import play, when
from toy_runs import Script, press_ctrl_c, toy, toy_run

pytestmark = pytest.mark.live

MISSING = ProcessSpec(name="plant", argv=("/nonexistent/program",))


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


def test_ctrl_c_in_a_change_starts_no_other_run() -> None:
    script = Script(toy_run("plant"))
    script.on_ready = lambda _number: script.session.start(toy_run("plant"))
    script.on_ended = lambda number: press_ctrl_c() if number == 1 else None

    end, _ = play(script)

    assert script.ready_runs == [1]
    assert end.cause is ExitCause.SIGNAL
    assert end.clean


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
