"""Files of a recording: they rotate without a gap, each is readable alone, and together they are one log."""

from itertools import count
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import Channel, Message
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, ScenarioInfo
from passafe_protocol.topics import EVENT, SCENARIO
from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.errors import LogReadError, LogWriteError
from passafe_services.log.log_files import files_of, part_path
from passafe_services.log.log_pass import LogPass
from passafe_services.log.log_reader import LogReader
from passafe_services.log.segmented_log import RawMessage, Rotation, SegmentedLog
from passafe_services.tables.run_tables import RunTables

S = 1_000_000_000
BETWEEN = 10
"""Messages between two flushes."""


def event(k: int, source: str = "plant") -> RawMessage:
    data = encode(Header(source, 1, k, 0, 0, 0, (k + 1) * S), Event("info", f"number {k}"))
    return RawMessage(EVENT.key(source), data, k, (k + 1) * S)


def scenario() -> RawMessage:
    data = encode(Header("filter", 1, 0, 0, 0, 0, S), ScenarioInfo("{}", "live", "{}"))
    return RawMessage(SCENARIO.key("filter"), data, 0, S)


def record(path: Path, messages: int, rotation: Rotation, counts: RecorderCounts | None = None) -> Chain:
    """Record messages of two sources, with a flush every ten of them and a clock that ticks with every flush."""
    chain, ticks = Chain("a recording"), count()
    log = SegmentedLog(path, {"driver": {"kind": "live"}}, chain, rotation=rotation, monotonic_ns=lambda: next(ticks))
    log.write(scenario())
    for k in range(messages):
        log.write(event(k, ("plant", "filter")[k // 40 % 2]))
        if k % BETWEEN == BETWEEN - 1:
            log.flush(counts or RecorderCounts())
    log.close(counts or RecorderCounts())
    return chain


def sequences(path: Path, *, alone: bool = False) -> list[int]:
    reader = LogReader(path, alone=alone)
    return [each.sequence for each in reader.records() if isinstance(each, Message) and len(each.data) != SCENARIO_SIZE]


SCENARIO_SIZE = len(scenario().data)


@pytest.mark.parametrize("rotation", [Rotation(after_ns=3), Rotation(size_bytes=4000)])
def test_files_rotate_without_a_gap(tmp_path: Path, rotation: Rotation) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, rotation)
    files = files_of(path)
    assert len(files) > 2
    assert files == [part_path(path, number + 1) for number in range(len(files))]
    assert files_of(tmp_path) == files
    for whole in (path, tmp_path):
        reader = LogReader(whole)
        assert sequences(whole) == list(range(100))
        list(reader.records())
        assert (reader.finished, reader.tear, reader.shortcomings) == (True, "", [])


def test_every_file_is_whole_in_itself(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    for file in files_of(path):
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            found = [(channel.topic, schema) for schema, channel, _ in reader.iter_messages()]
            names = {record.name for record in reader.iter_metadata()}
        assert all(schema is not None for _, schema in found)
        assert SCENARIO.key("filter") in {topic for topic, _ in found}
        assert {"driver", "recording", "checkpoint"} <= names


def test_channels_have_the_same_numbers_in_all_files(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    found = {(each.id, each.topic) for each in LogReader(path).records() if isinstance(each, Channel)}
    assert len(found) == 3


def test_a_pass_reads_all_files(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    run = LogPass(path)
    texts = [message.body.text for message in run.messages(Event)]
    assert sorted(texts) == sorted(f"number {k}" for k in range(100))
    assert (run.finished, run.tear, run.shortcomings) == (True, "", [])


def test_a_missing_file_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    part_path(path, 2).unlink()
    reader = LogReader(path)
    list(reader.records())
    assert not [each for each in reader.shortcomings if "missing" not in each]
    assert reader.shortcomings


def test_a_file_that_ends_early_is_named(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    second = part_path(path, 2)
    second.write_bytes(second.read_bytes()[:-2000])
    reader = LogReader(path)
    list(reader.records())
    assert not reader.finished
    assert reader.tear.startswith("run.2.mcap: of ")


def test_other_recordings_beside_it_do_not_count(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap", 10, Rotation())
    other = SegmentedLog(tmp_path / "run.2.mcap", {}, Chain("another"))
    other.close(RecorderCounts())
    assert files_of(tmp_path / "run.mcap") == [tmp_path / "run.mcap"]
    with pytest.raises(LogReadError, match=r"got 2 recordings \(run.2.mcap, run.mcap\)"):
        files_of(tmp_path)


def test_a_folder_without_a_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogReadError, match="got no recording"):
        files_of(tmp_path)


def test_counts_are_in_the_file_and_doubted_by_the_reader(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    counts = RecorderCounts(gaps={EVENT.key("plant"): 3}, lost={EVENT.key("filter"): 2})
    record(path, 10, Rotation(), counts)
    reader = LogReader(path)
    list(reader.records())
    assert reader.shortcomings == [
        f"messages that the recorder never received: 3 of {EVENT.key('plant')}",
        f"messages that the recorder could not write: 2 of {EVENT.key('filter')}",
    ]


def test_counts_survive_a_tear(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    log = SegmentedLog(path, {}, Chain("torn"))
    log.write(event(0))
    log.flush(RecorderCounts(gaps={EVENT.key("plant"): 3}))
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(path.read_bytes())
    log.close(RecorderCounts())
    reader = LogReader(torn)
    list(reader.records())
    assert reader.shortcomings == [
        "the recording does not end at its last checkpoint, 1",
        f"messages that the recorder never received: 3 of {EVENT.key('plant')}",
    ]


def test_after_a_full_disk_nothing_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.mcap"
    log = SegmentedLog(path, {}, Chain("full"))
    for k in range(5):
        log.write(event(k))
    log.flush(RecorderCounts())
    size = path.stat().st_size
    with monkeypatch.context() as patch:
        patch.setattr("os.fdatasync", _refuse)
        log.write(event(5))
        with pytest.raises(LogWriteError):
            log.flush(RecorderCounts())
        assert path.stat().st_size == size  # nothing is half written
        with pytest.raises(LogWriteError):
            log.reopen(RecorderCounts())
        assert list(tmp_path.iterdir()) == [path]
    log.reopen(RecorderCounts())
    log.write(event(6))
    log.close(RecorderCounts())
    reader = LogReader(path)
    assert [each.sequence for each in reader.records() if isinstance(each, Message)] == list(range(7))
    assert (reader.finished, reader.shortcomings) == (True, [])


def _refuse(_: int) -> None:
    raise OSError(28, "No space left on device")


def test_tables_of_a_set_say_which_file_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, 100, Rotation(after_ns=3))
    assert RunTables.read(path).shortcomings == ()

    files_of(path)[1].unlink()

    (said,) = RunTables.read(tmp_path).shortcomings
    assert "missing" in said
