"""The list of logs: what each says of itself, from its first and last bytes."""

import json
import os
from pathlib import Path

import pytest
from closed_form import header, paper_scenario
from closed_form_log import write_log
from passafe_dashboard.archive.log_head import LogHead, read_head
from passafe_dashboard.archive.log_list import LogLister
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.errors import ArchiveNameError
from passafe_protocol.messages import Event
from passafe_services.log.log_writer import LogWriter, run_metadata

LONG_AGO_S = 1_000_000_000


def short_log(path: Path) -> Path:
    return write_log(path, [(header("plant", 0, at_ns=1), Event("info", "here"))])


def age(path: Path) -> Path:
    os.utime(path, (LONG_AGO_S, LONG_AGO_S))
    return path


def test_a_log_says_its_scenario_and_mode(tmp_path: Path) -> None:
    scenario = paper_scenario()
    assert read_head(short_log(tmp_path / "a.mcap")) == LogHead(
        "finished", scenario.name, scenario.title, scenario.filter.mode, "lockstep"
    )


def test_a_log_says_what_a_what_if_changed(tmp_path: Path) -> None:
    metadata = run_metadata(scenario_json=paper_scenario().model_dump_json(), versions={}, driver="lockstep")
    change = {"key": "filter.k_i", "before": 20.0, "after": 5.0}
    metadata["what-if"] = {"source": "a.mcap", "changes": json.dumps([change])}
    with LogWriter(tmp_path / "b.mcap", metadata):
        pass
    head = read_head(tmp_path / "b.mcap")
    assert (head.source, head.changes) == ("a.mcap", ("filter.k_i 20.0 → 5.0",))


@pytest.mark.parametrize("text", [b"", b"hello", b"\x89MCAP0\r", b"x" * 300_000])
def test_a_file_that_is_no_log_is_called_so(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(text)
    assert read_head(tmp_path / "a.mcap") == LogHead("no log")


def test_a_log_without_an_end_is_being_recorded_or_torn(tmp_path: Path) -> None:
    whole = short_log(tmp_path / "a.mcap").read_bytes()
    (tmp_path / "a.mcap").write_bytes(whole[:-20])
    lister = LogLister(RunsFolder(tmp_path))
    assert lister.entry("a.mcap").state == "recording"
    age(tmp_path / "a.mcap")
    assert lister.entry("a.mcap").state == "torn"
    (tmp_path / "a.mcap").write_bytes(whole)
    assert lister.entry("a.mcap").state == "finished"


def test_the_newest_log_comes_first(tmp_path: Path) -> None:
    age(short_log(tmp_path / "a.mcap"))
    short_log(tmp_path / "b.mcap")
    found = LogLister(RunsFolder(tmp_path)).newest()
    assert [log.name for log in found.logs] == ["b.mcap", "a.mcap"]
    assert found.logs[1].modified_s == LONG_AGO_S
    assert found.left_out == 0


def test_files_of_one_recording_are_one_log(tmp_path: Path) -> None:
    first = short_log(tmp_path / "a.mcap")
    second = short_log(tmp_path / "a.2.mcap")
    short_log(tmp_path / "b.3.mcap")
    lister = LogLister(RunsFolder(tmp_path))
    found = {log.name: log for log in lister.newest().logs}
    assert sorted(found) == ["a.mcap", "b.3.mcap"]
    assert found["a.mcap"].files == 2
    assert found["a.mcap"].size_bytes == first.stat().st_size + second.stat().st_size
    assert lister.entry("a.mcap") == found["a.mcap"]


def test_a_log_with_broken_metadata_is_listed(tmp_path: Path) -> None:
    metadata = run_metadata(scenario_json='{"filter": 3}', versions={}, driver="lockstep")
    metadata["what-if"] = {"source": "a.mcap", "changes": "{}"}
    with LogWriter(tmp_path / "b.mcap", metadata):
        pass
    entry = LogLister(RunsFolder(tmp_path)).entry("b.mcap")
    assert (entry.scenario, entry.changes, entry.state) == ("", (), "finished")


def test_a_log_that_is_gone_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ArchiveNameError, match=r"log: got 'a\.mcap'"):
        LogLister(RunsFolder(tmp_path)).entry("a.mcap")
