"""Requests to a session: the newest wins, each refusal has its reason."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from dataclasses import replace
from pathlib import Path
from typing import Any

import passafe_services.session.run_requests
import pytest
from passafe_services.loop.process_name import ProcessName
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.session.control_messages import (
    EndRun,
    KillProcess,
    PageRequest,
    Refusal,
    RestartProcess,
    RunChoices,
    StartRun,
)
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.run_requests import RunRequests
from passafe_services.session.run_session import Phase, RunSession
from toy_runs import Script, toy_run

from passafe.errors import PassafeError


def start(scenario: str) -> StartRun:
    return StartRun(choices=RunChoices(scenario=scenario))


class Preparing:
    """Prepares runs; holds up those whose names begin with ``slow`` until they are released."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.began = threading.Event()
        self.release = threading.Event()
        self.asked: list[str] = []

    def __call__(self, request: StartRun) -> PlannedRun:
        """Prepare a run."""
        name = request.choices.scenario
        self.asked.append(name)
        self.began.set()
        if name.startswith("slow"):
            assert self.release.wait(20.0)
        file = self.folder / f"{name}.json"
        file.touch()
        return replace(toy_run(name), scenario_file=file)


@pytest.fixture
def session() -> RunSession:
    return Script(toy_run("first")).session


@pytest.fixture
def prepare(tmp_path: Path) -> Preparing:
    return Preparing(tmp_path)


def ask(session: RunSession, prepare: Callable[[StartRun], PlannedRun], *requests: PageRequest) -> list[Refusal | None]:
    """Handle requests one after the other; return the refusals."""
    handler = RunRequests(session, prepare)

    async def handle() -> list[Refusal | None]:
        return [await handler.handle(request) for request in requests]

    return asyncio.run(handle())


def test_accepted_run_is_wanted_next(session: RunSession, prepare: Preparing) -> None:
    assert ask(session, prepare, start("one")) == [None]
    assert session.wanted is not None
    assert session.wanted.choices.scenario == "one"


def test_same_run_twice_is_prepared_once(session: RunSession, prepare: Preparing) -> None:
    assert ask(session, prepare, start("one"), start("one"), start("two"), start("one")) == [None] * 4
    assert prepare.asked == ["one", "two", "one"]


def test_run_that_starts_is_not_started_again(session: RunSession, prepare: Preparing) -> None:
    assert session.phase == "starting"

    assert ask(session, prepare, start("first")) == [None]
    assert prepare.asked == []


async def overtaken(
    prepare: Preparing, handler: RunRequests, *later: PageRequest
) -> Coroutine[Any, Any, list[Refusal | None]]:
    """Ask for a slow run, then for something else while it is being prepared."""
    first = asyncio.create_task(handler.handle(start("slow")))
    await asyncio.to_thread(prepare.began.wait, 20.0)
    others = [asyncio.create_task(handler.handle(request)) for request in later]
    await asyncio.sleep(0)
    prepare.release.set()
    return [await task for task in (first, *others)]


def test_newest_of_runs_that_are_prepared_wins(session: RunSession, prepare: Preparing) -> None:
    work = overtaken(prepare, RunRequests(session, prepare), start("two"), start("three"), start("three"))
    refusals = asyncio.run(work)

    assert [refusal is None for refusal in refusals] == [False, False, True, True]
    assert refusals[0] == refusals[1] == Refusal(reason="a later request took its place")
    assert prepare.asked == ["slow", "three"]
    assert session.wanted is not None
    assert session.wanted.choices.scenario == "three"
    assert [path.name for path in prepare.folder.iterdir()] == ["three.json"]  # nothing is left of the other


def test_end_drops_a_run_that_is_being_prepared(session: RunSession, prepare: Preparing) -> None:
    refusals = asyncio.run(overtaken(prepare, RunRequests(session, prepare), EndRun()))

    assert refusals == [Refusal(reason="a later request took its place"), None]
    assert session.wanted is None


def test_end_without_a_run_is_refused(session: RunSession, prepare: Preparing) -> None:
    session.phase = "stopped"

    assert ask(session, prepare, EndRun()) == [Refusal(reason="no run is going on")]


@pytest.mark.parametrize(
    ("error", "field", "reason"),
    [
        (ScenarioError("a", "rate_hz", 1, "at least 10"), "rate_hz", "scenario a: rate_hz: got 1, allowed at least 10"),
        (PassafeError("it cannot be"), "scenario", "it cannot be"),
        (MemoryError("no more"), "", "the run cannot be prepared: no more"),
    ],
)
def test_run_that_cannot_be_is_refused_with_its_reason(
    error: Exception, field: str, reason: str, session: RunSession
) -> None:
    def fail(_request: StartRun) -> PlannedRun:
        raise error

    assert ask(session, fail, start("one"), start("one")) == [Refusal(field=field, reason=reason)] * 2
    assert session.wanted is None


def test_lack_of_threads_refuses_a_run(
    session: RunSession, prepare: Preparing, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail(_function: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(passafe_services.session.run_requests, "in_daemon_thread", fail)

    [refusal] = ask(session, prepare, start("one"))
    assert refusal == Refusal(reason="the run cannot be prepared: can't start new thread")


@pytest.mark.parametrize("request_type", [KillProcess, RestartProcess])
@pytest.mark.parametrize(
    ("process", "phase", "reason"),
    [
        (ProcessName.DASHBOARD, "running", "its own end"),
        (ProcessName.FILTER, "starting", "a run is starting"),
        (ProcessName.FILTER, "stopping", "a run is stopping"),
        (ProcessName.BRIDGE, "running", "no bridge is running"),
    ],
)
def test_process_that_may_not_be_touched_says_why(
    request_type: type[KillProcess | RestartProcess],
    process: ProcessName,
    phase: Phase,
    reason: str,
    session: RunSession,
    prepare: Preparing,
) -> None:
    session.phase = phase

    [refusal] = ask(session, prepare, request_type(process=process))
    assert refusal is not None
    assert reason in refusal.reason
    assert refusal.field == ""


def test_recorder_is_not_restarted_in_a_run(session: RunSession, prepare: Preparing) -> None:
    session.phase = "running"

    [refusal] = ask(session, prepare, RestartProcess(process=ProcessName.RECORDER))
    assert refusal == Refusal(reason="the log would be in two parts: start another run")


def test_emergency_stop_is_carried_over_a_restart_of_the_plant(
    session: RunSession, prepare: Preparing, monkeypatch: pytest.MonkeyPatch
) -> None:
    restarted = []
    monkeypatch.setattr(RunSession, "permitted", lambda *_: ("kill", "restart"))
    monkeypatch.setattr(RunSession, "kill", lambda *_: True)
    monkeypatch.setattr(RunSession, "restart", lambda _, *options: not restarted.append(options))

    requests = (
        KillProcess(process=ProcessName.PLANT),
        RestartProcess(process=ProcessName.PLANT, start_stopped=True),
        RestartProcess(process=ProcessName.FILTER, start_stopped=True),
    )
    assert ask(session, prepare, *requests) == [None] * 3
    assert restarted == [(ProcessName.PLANT, "--start-stopped"), (ProcessName.FILTER,)]
