"""Damaged logs: everything intact is kept, before and after the damage, and what is lost is named."""

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Footer, McapRecord, Message
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.record_scan import scan_records
from passafe_services.tools.recover import recover

CHUNKS = 4
BETWEEN = 10
"""Messages of a chunk."""
KEY = "passafe/robot/plant/event"
S = 1_000_000_000


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of four chunks with ten messages each; message k at k seconds has sequence k."""
    path = tmp_path / "log.mcap"
    with LogWriter(path, {"driver": {"kind": "live"}}) as writer:
        for k in range(CHUNKS * BETWEEN):
            data = encode(Header("plant", 1, k, 0, 0, 0, (k + 1) * S), Event("info", f"number {k}"))
            writer.write(KEY, data, sequence=k, wall_ns=(k + 1) * S)
            if (k + 1) % BETWEEN == 0:
                writer.flush()
    return path


def chunks(path: Path) -> list[tuple[int, int]]:
    """Return beginning and end of every chunk."""
    with path.open("rb") as stream:
        found = list(scan_records(stream, path.stat().st_size))
    return [(each.start, each.end) for each in found if getattr(each, "opcode", 0) == 6]


def numbers(path: Path) -> list[int]:
    """Return the sequence numbers that mcap's own reader finds."""
    with path.open("rb") as stream:
        return [message.sequence for _, _, message in make_reader(stream, validate_crcs=True).iter_messages()]


def without(*lost: int) -> list[int]:
    """Return the sequence numbers of all chunks but these."""
    return [k for k in range(CHUNKS * BETWEEN) if k // BETWEEN not in lost]


def test_chunks_after_a_flipped_byte_are_kept(tmp_path: Path, log: Path) -> None:
    content = bytearray(log.read_bytes())
    start, end = chunks(log)[1]
    content[(start + end) // 2] ^= 0x10
    log.write_bytes(content)
    recovery = recover(log, tmp_path / "out.mcap")
    assert numbers(tmp_path / "out.mcap") == without(1)
    [loss] = recovery.losses
    assert (loss.damage.start, loss.damage.end) == (start, end)
    assert (loss.damage.first_ns, loss.damage.last_ns) == (11 * S, 20 * S)
    assert (loss.after_ns, loss.before_ns) == (10 * S, 21 * S)
    assert loss.missing == {KEY: (10, 19)}
    assert not recovery.was_finished


def zeroed(content: bytearray, start: int, end: int) -> None:
    """Zero the middle of the record, its head included."""
    content[start : start + (end - start) // 2] = bytes((end - start) // 2)


def cut_out(content: bytearray, start: int, end: int) -> None:
    """Take the middle of the record out."""
    del content[start + 20 : (start + end) // 2]


def longer(content: bytearray, start: int, _end: int) -> None:
    """Let the record's length be wrong."""
    content[start + 2] ^= 0x40


def of_another_kind(content: bytearray, start: int, _end: int) -> None:
    """Let the record be of a kind that is free for extensions."""
    content[start] |= 0x80


@pytest.mark.parametrize("damage", [zeroed, cut_out, longer, of_another_kind])
@pytest.mark.parametrize("which", range(CHUNKS))
def test_other_chunks_survive(
    tmp_path: Path, log: Path, damage: Callable[[bytearray, int, int], None], which: int
) -> None:
    content = bytearray(log.read_bytes())
    start, end = chunks(log)[which]
    damage(content, start, end)
    log.write_bytes(content)
    recovery = recover(log, tmp_path / "out.mcap")
    assert numbers(tmp_path / "out.mcap") == without(which)
    assert [loss.damage.start for loss in recovery.losses] == [start]
    reader = LogReader(log)
    assert [record.sequence for record in reader.records() if isinstance(record, Message)] == without(which)
    assert not reader.finished
    assert str(start) in reader.tear


def test_a_damaged_beginning_is_no_reason_to_refuse(tmp_path: Path, log: Path) -> None:
    content = bytearray(log.read_bytes())
    start, _ = chunks(log)[0]
    content[:start] = bytes(start)
    log.write_bytes(content)
    recovery = recover(log, tmp_path / "out.mcap")
    assert numbers(tmp_path / "out.mcap") == without()
    assert recovery.losses[0].damage.reason == "not the first bytes of an MCAP file"


def test_a_damaged_index_loses_no_message(tmp_path: Path, log: Path) -> None:
    content = log.read_bytes()
    log.write_bytes(content[:-60])
    recovery = recover(log, tmp_path / "out.mcap")
    assert numbers(tmp_path / "out.mcap") == without()
    assert recovery.losses[0].before_ns is None


def uncompressed(path: Path, *, chunked: bool) -> None:
    """Write the log of another program, whose messages are in the file as they are."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, use_chunking=chunked)
        writer.start("", "elsewhere")
        channel = writer.register_channel("/a", "json", 0)
        for k in range(30):
            writer.add_message(channel, k + 1, b'{"number": %d}' % k, k + 1, k)
            if chunked and k % 10 == 9:
                writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated


@pytest.mark.parametrize("which", range(3))
def test_messages_in_a_damaged_chunk_are_not_believed(tmp_path: Path, which: int) -> None:
    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    uncompressed(path, chunked=True)
    content = bytearray(path.read_bytes())
    start, _ = chunks(path)[which]
    content[start : start + 9] = bytes(9)
    path.write_bytes(content)
    recover(path, out)
    assert numbers(out) == [k for k in range(30) if k // 10 != which]


def test_messages_outside_of_chunks_are_kept_around_damage(tmp_path: Path) -> None:
    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    uncompressed(path, chunked=False)
    content = path.read_bytes()
    at = content.index(b'{"number": 7}')
    path.write_bytes(content[: at - 31] + bytes(10) + content[at - 21 :])
    recover(path, out)
    assert numbers(out) == [k for k in range(30) if k != 7]


def test_a_chunk_that_claims_much_memory_is_damage(log: Path) -> None:
    start, _ = chunks(log)[2]
    content = bytearray(log.read_bytes())
    content[start + 9 + 16 : start + 9 + 24] = (2**40).to_bytes(8, "little")
    log.write_bytes(content)
    reader = LogReader(log)
    assert [record.sequence for record in reader.records() if isinstance(record, Message)] == without(2)
    assert "allowed 1073741824" in reader.tear


def test_messages_without_a_channel_are_counted(tmp_path: Path) -> None:
    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False, repeat_channels=False)
        writer.start("", "elsewhere")
        writer.add_message(5, 1, b"x", 1)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    assert recover(path, out).orphans == 1
    assert numbers(out) == []


def test_the_reader_finds_what_mcaps_own_finds(log: Path) -> None:
    def kept(records: Iterator[McapRecord]) -> list[McapRecord]:
        return [record for record in records if isinstance(record, Message | Channel | Footer)]

    with log.open("rb") as stream:
        theirs = kept(StreamReader(stream, validate_crcs=True).records)
    assert kept(LogReader(log).records()) == theirs


def test_attachments_are_kept(tmp_path: Path) -> None:
    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("", "elsewhere")
        writer.add_attachment(3, 4, "notes", "text/plain", b"it rained")
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    recover(path, out)
    with out.open("rb") as stream:
        [kept] = make_reader(stream).iter_attachments()
    assert (kept.create_time, kept.log_time, kept.name, kept.data) == (3, 4, "notes", b"it rained")


def test_chunks_with_contents_that_are_no_records_are_damage(tmp_path: Path, log: Path) -> None:
    start, end = chunks(log)[1]
    builder = RecordBuilder()
    Chunk("", b"\x05" + bytes(8), 2, 1, 0, 9).write(builder)
    content = log.read_bytes()
    log.write_bytes(content[:start] + builder.end() + content[end:])
    recover(log, tmp_path / "out.mcap")
    assert numbers(tmp_path / "out.mcap") == without(1)


@pytest.mark.parametrize("seed", range(8))
def test_any_damage_leaves_a_log_that_readers_accept(tmp_path: Path, log: Path, seed: int) -> None:
    chance = random.Random(seed)
    content = bytearray(log.read_bytes())
    at = chance.randrange(8, len(content))
    content[at : at + chance.randrange(300)] = chance.randbytes(chance.randrange(300))
    log.write_bytes(content)
    recovery = recover(log, tmp_path / "out.mcap")
    assert len(numbers(tmp_path / "out.mcap")) == recovery.messages
    assert set(numbers(tmp_path / "out.mcap")) <= set(without())
