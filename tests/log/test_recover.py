"""Whole logs out of torn ones, wherever the tear is."""

import errno
import json
import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Message
from mcap.writer import CompressionType, Writer
from passafe_services.log.errors import LogReadError, LogWriteError
from passafe_services.log.log_reader import LogReader
from passafe_services.log.record_scan import Damage, IntactRecord, scan_records
from passafe_services.tools.recover import recover
from torn_logs import WALL_NS, contents, end_of_first, metadata, write_log

MS = 1_000_000


def test_everything_before_the_tear_is_kept(tmp_path: Path) -> None:
    whole, torn, out = (tmp_path / name for name in ("whole.mcap", "torn.mcap", "out.mcap"))
    sizes = write_log(whole)
    torn.write_bytes(whole.read_bytes()[: sizes[2] + 30])
    before = torn.read_bytes()
    recovery = recover(torn, out)
    assert recovery.messages == 30
    assert recovery.duration_s == pytest.approx(0.029)
    assert recovery.channels == {"passafe/robot/plant/event": 15, "passafe/robot/filter/event": 15}
    assert not recovery.was_finished
    assert f"of {sizes[2] + 30} bytes" in recovery.tear
    assert contents(out) == contents(whole)[:30]
    kept = metadata(out)
    assert kept["driver"] == {"kind": "live"}
    assert kept["recovered"]["tear"] == recovery.tear
    assert kept["recovered"]["messages"] == "30"
    [loss] = json.loads(kept["recovered"]["losses"])
    assert (loss["start_byte"], loss["end_byte"], loss["reason"]) == (sizes[2], sizes[2] + 30, "cut off")
    assert (loss["after_ns"], loss["before_ns"], loss["missing"]) == (WALL_NS + 29 * MS, None, {})
    assert torn.read_bytes() == before


def test_a_whole_log_is_copied(tmp_path: Path) -> None:
    whole, out = tmp_path / "whole.mcap", tmp_path / "out.mcap"
    write_log(whole)
    recovery = recover(whole, out)
    assert (recovery.messages, recovery.was_finished, recovery.tear) == (50, True, "")
    assert contents(out) == contents(whole)
    assert metadata(out) == metadata(whole)


def test_logs_of_other_programs_are_recovered_as_they_are(tmp_path: Path) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    with torn.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "elsewhere")
        schema = writer.register_schema("sensor_msgs/Image", "ros2msg", b"uint8 x")
        with_schema = writer.register_channel("/image", "cdr", schema, {"qos": "best"})
        without = writer.register_channel("/raw", "json", 0)
        writer.add_message(with_schema, 7, b"pixels", 6, 5)
        writer.add_message(without, 9, b"{}", 8, 4)
        writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    recovery = recover(torn, out)
    assert recovery.channels == {"/image": 1, "/raw": 1}
    with out.open("rb") as stream:
        found = list(make_reader(stream).iter_messages())
    image, raw = found
    assert image[0] is not None
    assert (image[0].name, image[0].encoding, image[0].data) == ("sensor_msgs/Image", "ros2msg", b"uint8 x")
    assert (image[1].message_encoding, image[1].metadata) == ("cdr", {"qos": "best"})
    assert (image[2].log_time, image[2].publish_time, image[2].sequence) == (7, 6, 5)
    assert (raw[0], raw[1].message_encoding, raw[2].data) == (None, "json", b"{}")


@pytest.mark.parametrize("same", [True, False])
def test_no_file_is_overwritten(tmp_path: Path, *, same: bool) -> None:
    torn, other = tmp_path / "torn.mcap", tmp_path / "other.mcap"
    write_log(torn)
    other.write_text("somebody's")
    out = torn if same else other
    before = out.read_bytes()
    with pytest.raises(LogWriteError, match="File exists"):
        recover(torn, out)
    assert out.read_bytes() == before


def test_a_recovery_that_fails_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    write_log(torn)

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fdatasync", full)
    with pytest.raises(LogWriteError, match="No space left") as caught:
        recover(torn, out)
    assert caught.value.path == out
    assert list(tmp_path.iterdir()) == [torn]


@pytest.mark.parametrize("links", [True, False])
def test_what_a_killed_recovery_left_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, links: bool
) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    write_log(torn)
    (tmp_path / ".out.mcap.part").write_text("half a log")
    if not links:

        def without_links(*_: object) -> None:
            raise OSError(errno.EPERM, os.strerror(errno.EPERM))

        monkeypatch.setattr(os, "link", without_links)
    recover(torn, out)
    assert contents(out) == contents(torn)
    assert set(tmp_path.iterdir()) == {torn, out}


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is empty"),
        (b"\x89MCAP1\r\n", "is no MCAP file"),
        (b"time,x\n0.0,1.0\n" * 50, "is no MCAP file"),
        (bytes(range(256)) * 20, "is no MCAP file"),
        (None, "no such file"),
    ],
)
def test_what_is_no_log_is_refused_and_nothing_written(tmp_path: Path, content: bytes | None, reason: str) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    if content is not None:
        torn.write_bytes(content)
    with pytest.raises(LogReadError, match=reason):
        recover(torn, out)
    assert not out.exists()


def test_folder_is_refused_and_nothing_written(tmp_path: Path) -> None:
    folder, out = tmp_path / "runs", tmp_path / "out.mcap"
    folder.mkdir()
    write_log(folder / "run.mcap")
    with pytest.raises(LogReadError, match="cannot be read: Is a directory"):
        recover(folder, out)
    assert not out.exists()


def test_a_chunk_that_was_altered_is_not_believed(tmp_path: Path) -> None:
    path = tmp_path / "altered.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        channel = writer.register_channel("/a", "json", 0)
        writer.add_message(channel, 1, b"first chunk", 1)
        writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        writer.add_message(channel, 2, b"second chunk", 2)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    path.write_bytes(path.read_bytes().replace(b"second", b"sEcond"))
    reader = LogReader(path)
    messages = [record.data for record in reader.records() if isinstance(record, Message)]
    assert messages == [b"first chunk"]
    assert not reader.finished
    assert "chunk: crc validation failed" in reader.tear


def test_a_record_longer_than_the_file_is_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "long.mcap"
    write_log(path)
    chunk = b"\x06" + (2**40).to_bytes(8, "little")
    path.write_bytes(path.read_bytes()[:8] + chunk + b"little")
    reader = LogReader(path)
    assert list(reader.records()) == []
    assert reader.damage == [Damage(start=8, end=path.stat().st_size, reason="cut off")]


@pytest.fixture(scope="module")
def log_bytes(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[int], int]:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    sizes = write_log(path)
    return path.read_bytes(), sizes, end_of_first(Opcode.METADATA, path)


@settings(deadline=None, max_examples=60)
@given(data=st.data())
def test_every_flush_before_a_tear_anywhere_is_kept(
    log_bytes: tuple[bytes, list[int], int], tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    content, sizes, first = log_bytes
    cut = data.draw(st.integers(8, len(content) - 1))
    path = tmp_path_factory.mktemp("torn") / "torn.mcap"
    path.write_bytes(content[:cut])
    if cut < first:
        with pytest.raises(LogReadError, match="nothing to recover"):
            recover(path, path.with_name("out.mcap"))
        return
    recovery = recover(path, path.with_name("out.mcap"))
    flushed = sum(size <= cut for size in sizes) * 10
    assert flushed <= recovery.messages <= flushed + 10
    assert len(contents(path.with_name("out.mcap"))) == recovery.messages


@settings(deadline=None, max_examples=100)
@given(data=st.data())
def test_no_damage_raises(
    log_bytes: tuple[bytes, list[int], int], tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    content, _, _ = log_bytes
    damaged = bytearray(content)
    for _ in range(data.draw(st.integers(1, 5))):
        damaged[data.draw(st.integers(8, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("damaged") / "damaged.mcap"
    path.write_bytes(damaged)
    reader = LogReader(path)
    records = list(reader.records())
    assert reader.finished or reader.tear
    assert len(records) <= 200


@pytest.mark.parametrize("kind", [Opcode.CHUNK, Opcode.CHANNEL, Opcode.SCHEMA])
def test_record_whose_kind_was_changed_is_no_message(tmp_path: Path, kind: Opcode) -> None:
    whole, out = tmp_path / "whole.mcap", tmp_path / "out.mcap"
    write_log(whole)
    with whole.open("rb") as stream:
        records = [each for each in scan_records(stream, whole.stat().st_size) if isinstance(each, IntactRecord)]
    starts = [each.start for each in records if each.opcode == kind]
    data = bytearray(whole.read_bytes())
    data[starts[-1]] = Opcode.MESSAGE
    whole.write_bytes(data)

    recovery = recover(whole, out)

    assert [loss.damage.start for loss in recovery.losses] == starts[-1:]
    assert recovery.losses[0].damage.reason == "a message outside of the chunks"
    assert recovery.messages == len(contents(out)) == (40 if kind == Opcode.CHUNK else 50)
    assert not recovery.was_finished
