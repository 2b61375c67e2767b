"""Reports of the runs of a demo: which are judged, when, and which decides the exit code."""

import asyncio
import io
import threading
from pathlib import Path

import pytest
from passafe_services.cli.demo_outcome import DIED
from passafe_services.cli.demo_reports import DemoReports
from passafe_services.loop.process_exit import ExitCause, RunOutcome
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.session.control_messages import RunChoices
from passafe_services.session.planned_run import PlannedRun
from rich.console import Console
from short_run import ended, write_log


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario("notomista-cai-2020", {"rate_hz": 200.0, "filter.k_i": 50.0, "plant.hold_s": 0.01})


@pytest.fixture
def console() -> Console:
    return Console(file=io.StringIO(), width=300, soft_wrap=True)


@pytest.fixture
def reports(console: Console) -> DemoReports:
    return DemoReports(console, "http://127.0.0.1:8080/")


def printed(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def run_of(scenario: Scenario, log: Path | None, *, most_s: float | None = None) -> PlannedRun:
    return PlannedRun(
        choices=RunChoices(scenario=scenario.name),
        scenario=scenario,
        scenario_file=Path("a.json"),
        log=log,
        specs=(),
        most_s=most_s,
    )


def end(
    reports: DemoReports, number: int, run: PlannedRun, outcome: RunOutcome, *, began: bool = True
) -> list[tuple[str, str]]:
    """End a run; return the verdicts that the session received until the review is over."""
    verdicts: list[tuple[str, str]] = []

    async def wait() -> None:
        concluded = asyncio.Event()

        def conclude(outcome: str, words: str) -> None:
            verdicts.append((outcome, words))
            concluded.set()

        reports.ended(number, run, outcome, conclude, began=began)
        if began and outcome.cause is ExitCause.REQUESTED:
            await asyncio.wait_for(concluded.wait(), 30.0)

    asyncio.run(wait())
    return verdicts


def test_requested_end_is_judged_beside_the_next_run(
    tmp_path: Path, scenario: Scenario, reports: DemoReports, console: Console
) -> None:
    run = run_of(scenario, write_log(tmp_path / "run.mcap", scenario, planned_s=None))

    assert end(reports, 1, run, ended(ExitCause.REQUESTED, None)) == [("holds", "holds")]
    assert "verdict   holds" in printed(console)
    assert reports.finish() == 0


def test_worst_of_all_runs_decides(tmp_path: Path, scenario: Scenario, reports: DemoReports) -> None:
    gone = run_of(scenario, tmp_path / "gone.mcap")
    whole = run_of(scenario, write_log(tmp_path / "run.mcap", scenario, planned_s=None))

    [(outcome, words)] = end(reports, 1, gone, ended(ExitCause.REQUESTED, None))
    assert (outcome, words) == ("unproven", "this run has no log")
    assert end(reports, 2, whole, ended(ExitCause.SIGNAL, None)) == []
    assert reports.finish() == DIED


def test_run_without_a_recorder_has_no_verdict(scenario: Scenario, reports: DemoReports, console: Console) -> None:
    run = run_of(scenario, None)

    assert end(reports, 2, run, ended(ExitCause.REQUESTED, None)) == [("", "not recorded: no verdict")]
    assert "run 2, notomista-cai-2020, mode both, 200 Hz, not recorded: " in printed(console)
    assert reports.finish() == 0

    end(reports, 3, run, ended(ExitCause.DIED, "filter", returncode=1))
    assert reports.finish() == DIED


@pytest.mark.parametrize(("cause", "number"), [(ExitCause.REQUESTED, 1), (ExitCause.SIGNAL, 2)])
def test_run_that_never_began_is_not_judged(
    cause: ExitCause, number: int, tmp_path: Path, scenario: Scenario, reports: DemoReports, console: Console
) -> None:
    run = run_of(scenario, tmp_path / "gone.mcap")

    assert end(reports, number, run, ended(cause, None), began=False) == []
    assert f"run {number} was ended before it began: nothing to judge" in printed(console)
    assert reports.finish() == 0


def test_lack_of_threads_leaves_the_review_to_the_end(
    tmp_path: Path, scenario: Scenario, reports: DemoReports, console: Console, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", fail)
    run = run_of(scenario, write_log(tmp_path / "run.mcap", scenario, planned_s=None))
    verdicts: list[str] = []

    async def begin() -> None:
        reports.ended(1, run, ended(ExitCause.REQUESTED, None), lambda word, _: verdicts.append(word), began=True)

    asyncio.run(begin())
    assert "verdict" not in printed(console)
    assert reports.finish() == 0
    assert "verdict   holds" in printed(console)
    assert verdicts == []  # nobody listens any more


def test_first_run_names_the_address_and_later_ones_themselves(
    scenario: Scenario, reports: DemoReports, console: Console
) -> None:
    blind = scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"prediction": False})})
    reports.ready(1, run_of(scenario, Path("one.mcap")))
    reports.ready(2, run_of(blind, None))

    assert printed(console).splitlines() == [
        "dashboard http://127.0.0.1:8080/",
        "running; end with Ctrl-C",
        "run 2: notomista-cai-2020, mode both, without prediction, 200 Hz, not recorded",
    ]


def test_run_with_an_end_says_how_long_it_takes(scenario: Scenario, console: Console) -> None:
    DemoReports(console, "").ready(1, run_of(scenario, None, most_s=70.0))

    assert printed(console) == f"running for {scenario.duration_s:g} s\n"
