"""Ends of a demo: exit code, verdict, and where the log is."""

import io
from pathlib import Path

import passafe_services.cli.demo_outcome
import pytest
from passafe_services.cli.demo_outcome import DIED, report_outcome
from passafe_services.cli.demo_processes import rotation_options
from passafe_services.log.errors import LogReadError, LogWriteError
from passafe_services.loop.process_exit import ExitCause
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from rich.console import Console
from short_run import ended, write_log


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario("notomista-cai-2020", {"rate_hz": 200.0, "filter.k_i": 50.0, "plant.hold_s": 0.01})


@pytest.fixture
def console() -> Console:
    return Console(file=io.StringIO(), width=300)


@pytest.fixture
def printed(console: Console, capsys: pytest.CaptureFixture[str]) -> "Printed":
    return Printed(console, capsys)


class Printed:
    """Everything that was printed so far."""

    def __init__(self, console: Console, capsys: pytest.CaptureFixture[str]) -> None:
        self._console, self._capsys = console, capsys

    def text(self) -> str:
        assert isinstance(self._console.file, io.StringIO)
        return self._console.file.getvalue() + self._capsys.readouterr().out


def test_whole_run_ended_by_its_plant_holds(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed
) -> None:
    log = write_log(tmp_path / "run.mcap", scenario)

    assert report_outcome(ended(ExitCause.LEFT, "plant"), log, console) == 0
    assert "verdict   holds" in printed.text()


@pytest.mark.parametrize("leaver", ["router", "recorder", "dashboard", "operator", "filter"])
def test_run_that_another_process_left_is_no_success(
    leaver: str, tmp_path: Path, scenario: Scenario, console: Console, printed: Printed
) -> None:
    log = write_log(tmp_path / "run.mcap", scenario)

    assert report_outcome(ended(ExitCause.LEFT, leaver), log, console) == DIED
    assert f"{leaver} ended" in printed.text()


def test_a_plant_that_was_to_run_on_may_not_leave(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed
) -> None:
    log = write_log(tmp_path / "run.mcap", scenario, planned_s=None)

    assert report_outcome(ended(ExitCause.LEFT, "plant"), log, console) == DIED
    assert "plant ended" in printed.text()
    assert report_outcome(ended(ExitCause.SIGNAL, None), log, console) == 0


def test_run_without_a_log_says_so(tmp_path: Path, console: Console, printed: Printed) -> None:
    gone, empty = tmp_path / "gone" / "run.mcap", tmp_path / "empty.mcap"
    empty.touch()

    assert report_outcome(ended(ExitCause.LEFT, "plant"), gone, console) == DIED
    assert report_outcome(ended(ExitCause.LEFT, "plant"), empty, console) == DIED
    text = printed.text()
    assert f"this run has no log: {gone}: no such file" in text
    assert f"this run has no log: {empty}: " in text


def test_unfinished_log_is_recovered_and_no_proof(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed
) -> None:
    log = write_log(tmp_path / "run.mcap", scenario, finished=False)

    assert report_outcome(ended(ExitCause.DIED, "recorder", returncode=-9), log, console) == DIED
    text = printed.text()
    assert "messages were recovered from" in text
    assert "verdict   unproven" in text
    assert {path.name for path in tmp_path.iterdir()} == {"run.mcap", "run.torn.mcap"}


def test_full_disk_leaves_verdict_and_path(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(torn: Path, out: Path) -> None:
        out.write_bytes(b"the first bytes")
        raise LogWriteError(out, OSError(28, f"No space left on device, reading {torn.name}"))

    monkeypatch.setattr(passafe_services.cli.demo_outcome, "recover", full)
    log = write_log(tmp_path / "run.mcap", scenario, finished=False)

    assert report_outcome(ended(ExitCause.DIED, "recorder", returncode=2), log, console) == DIED
    text, torn = printed.text(), tmp_path / "run.torn.mcap"
    assert "No space left on device" in text
    assert f"what was recorded is in {torn}" in text
    assert f"log       {torn}" in text
    assert "verdict   unproven" in text
    assert list(tmp_path.iterdir()) == [torn]


def test_file_of_which_nothing_is_intact_stays_as_it_is(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing(torn: Path, _out: Path) -> None:
        raise LogReadError(torn, "nothing to recover")

    monkeypatch.setattr(passafe_services.cli.demo_outcome, "recover", nothing)
    log = write_log(tmp_path / "run.mcap", scenario, finished=False)

    assert report_outcome(ended(ExitCause.SIGNAL, None), log, console) == 1
    text = printed.text()
    assert "nothing to recover" in text
    assert f"log       {log}" in text
    assert list(tmp_path.iterdir()) == [log]


def test_folder_that_cannot_be_written_keeps_the_log(
    tmp_path: Path, scenario: Scenario, console: Console, printed: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_from: Path, _to: Path) -> None:
        raise OSError(30, "Read-only file system")

    log = write_log(tmp_path / "run.mcap", scenario, finished=False)
    monkeypatch.setattr(Path, "rename", refuse)

    assert report_outcome(ended(ExitCause.SIGNAL, None), log, console) == 1
    assert f"what was recorded is in {log}" in printed.text()
    assert list(tmp_path.iterdir()) == [log]


def test_limits_of_files_are_options_of_the_recorder() -> None:
    assert rotation_options(2.5, 60.0) == ("--rotate-mb", "2.5", "--rotate-s", "60.0")
    assert rotation_options(None, None) == ()
