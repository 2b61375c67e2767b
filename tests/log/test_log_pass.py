"""A pass over a log: order, gaps, damage, channels and processes, by logs whose contents are known."""

import os
import random
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, Health, PlantPhase, PlantState
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log import log_pass
from passafe_services.log.decoding_workers import DecodingWorkerLostError, DecodingWorkers
from passafe_services.log.errors import ForeignLogError, LogReadError
from passafe_services.log.log_pass import LogPass, LogSlice
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.message_columns import RECORD, WIRE

WALL_NS = 1_763_800_000_000_000_000


def event(source: str, sequence: int, epoch: int = 1) -> tuple[Header, Event]:
    wall_ns = WALL_NS + sequence
    return Header(source, epoch, sequence, 1, 2, 3, wall_ns), Event("info", f"{source} {epoch} {sequence}")


def state(sequence: int) -> tuple[Header, PlantState]:
    header = Header("plant", 1, sequence, 1, 2, 3, WALL_NS + sequence)
    body = PlantState(
        plant_ns=1000 * sequence,
        x=(float(sequence), -1.0),
        y=(0.0,),
        u=(0.5,),
        applied_tick=sequence,
        phase=PlantPhase.RUNNING,
        energy_in_j=0.0,
        energy_stored_j=0.0,
        input_lead_ns=0,
        inputs_late=0,
        inputs_refused=0,
        integration_error=0.0,
        received_tick=0,
    )
    return header, body


def write(path: Path, messages: list[tuple[Header, Event | PlantState]], *, flush_every: int = 10**9) -> Path:
    with LogWriter(path, {"scenario": {"json": "{}"}}) as log:
        for number, (header, body) in enumerate(messages):
            key = TOPIC_OF_BODY[type(body)].key(header.source)
            log.write(key, encode(header, body), sequence=header.sequence, wall_ns=header.wall_ns)
            if number % flush_every == flush_every - 1:
                log.flush()
    return path


def texts(run: LogPass) -> list[str]:
    return [body.text for _, body in run.messages(Event)]


def test_messages_come_in_order_however_they_were_logged(tmp_path: Path) -> None:
    messages = [event("plant", n) for n in range(200)] + [event("filter", n, epoch=9) for n in range(200)]
    random.Random(1).shuffle(messages)
    run = LogPass(write(tmp_path / "run.mcap", [*messages, *messages[:7]]))

    found = texts(run)

    assert [text for text in found if "plant" in text] == [f"plant 1 {n}" for n in range(200)]
    assert [text for text in found if "filter" in text] == [f"filter 9 {n}" for n in range(200)]
    count = run.counts["event"]
    assert (count.received, count.duplicates, count.gaps, count.sessions) == (400, 7, 0, 2)
    assert run.finished
    assert not run.tear


def test_gaps_are_counted_per_session(tmp_path: Path) -> None:
    numbers = {("plant", 1): (0, 1, 2), ("filter", 7): (5, 3, 8, 3), ("plant", 2): (0, 4)}
    messages = [event(source, n, epoch) for (source, epoch), of in numbers.items() for n in of]
    run = LogPass(write(tmp_path / "run.mcap", messages))

    assert len(texts(run)) == 8
    count = run.counts["event"]
    assert (count.duplicates, count.gaps, count.missed_at_start, count.sessions) == (1, 1 + 2 + 3, 3, 3)
    assert count.first_gap_wall_ns == WALL_NS


def test_what_comes_after_its_window_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_pass, "STRETCH_BYTES", 1)
    monkeypatch.setattr("passafe_services.log.session_order.WINDOW", 8)
    order = [0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 2, 14, 14]
    run = LogPass(write(tmp_path / "run.mcap", [event("plant", n) for n in order], flush_every=1))

    assert texts(run) == [f"plant 1 {n}" for n in (0, 1, *range(3, 15))]
    count = run.counts["event"]
    assert (count.out_of_order, count.gaps, count.duplicates) == (1, 1, 1)


def test_columns_and_wire_bytes_have_one_row_a_message(tmp_path: Path) -> None:
    messages = [state(n) for n in range(50)]
    run = LogPass(write(tmp_path / "run.mcap", list(messages)))
    blocks = [
        block
        for part in run.slices({"state": ("x", "phase", WIRE, RECORD, "stop_source")})
        for block in part.blocks("state")
    ]

    assert sum(len(block) for block in blocks) == 50
    np.testing.assert_array_equal(np.hstack([block.matrix("x", 2) for block in blocks])[0], np.arange(50.0))
    assert [wire for block in blocks for wire in block.objects(WIRE)] == [encode(*message) for message in messages]
    assert [record for block in blocks for record in block.objects(RECORD)] == messages
    assert (blocks[0].source, blocks[0].epoch, blocks[0].session) == ("plant", 1, 0)
    assert blocks[0].texts("stop_source").are("").all()
    with pytest.raises(TypeError, match=r"state\.x: got Ragged"):
        blocks[0].numbers("x")


class Collector:
    """Consumer that keeps what it takes."""

    def __init__(self, **wants: tuple[str, ...]) -> None:
        self.wants = wants
        self.parts: list[LogSlice] = []

    def take(self, part: LogSlice) -> None:
        self.parts.append(part)


def test_consumers_share_one_pass(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", [state(n) for n in range(5)])
    first, second, read = Collector(state=("x",)), Collector(state=("u",), event=("text",)), []

    LogPass(path, progress=lambda done, total: read.append((done, total))).feed(first, second)

    assert first.parts == second.parts
    [block] = [block for part in first.parts for block in part.blocks("state")]
    assert {"x", "u"} <= block.columns.keys()
    assert read[-1][0] <= read[-1][1] == path.stat().st_size


@pytest.mark.parametrize("workers", [0, 1])
def test_pass_for_some_topics_passes_the_others_over(tmp_path: Path, workers: int) -> None:
    messages = [each for n in range(100) for each in (event("filter", n), state(n))]
    run = LogPass(write(tmp_path / "run.mcap", messages), workers=workers)

    parts = [*run.slices({"state": ("plant_ns",)}, wanted_only=True)]

    assert not any(part.blocks("event") for part in parts)
    assert [run.counts[name].received for name in ("state", "event")] == [100, 0]
    assert [*run.slices({"tick": ()}, wanted_only=True)]  # no topic of its own, but a log of passafe all the same


@pytest.mark.parametrize("workers", [0, 2])
def test_a_channel_that_comes_late_is_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int) -> None:
    monkeypatch.setattr(log_pass, "STRETCH_BYTES", 1)  # every chunk by itself
    messages: list[tuple[Header, Event | PlantState]] = [state(n) for n in range(3)]
    messages += [event("plant", n) for n in range(9)]
    path = write(tmp_path / "run.mcap", messages, flush_every=1)

    run = LogPass(path, workers=workers)

    assert texts(run) == [f"plant 1 {n}" for n in range(9)]
    assert run.counts["state"].received == 3


def third_chunk(data: bytes | bytearray) -> int:
    """Return the place of the compressed bytes of the third chunk."""
    return [at for at in range(len(data)) if data.startswith(b"\x28\xb5\x2f\xfd", at)][2]


def test_damage_is_named_and_what_follows_it_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "run.mcap", [event("plant", n) for n in range(40)], flush_every=10)
    data = bytearray(path.read_bytes())
    data[third_chunk(data) + 30] ^= 0xFF
    path.write_bytes(bytes(data))
    for stretch_bytes in (1, 1 << 20):
        monkeypatch.setattr(log_pass, "STRETCH_BYTES", stretch_bytes)
        run = LogPass(path)

        assert texts(run) == [f"plant 1 {n}" for n in range(40) if n // 10 != 2]
        assert not run.finished
        assert f"of {len(data)} bytes" in run.tear


def test_a_torn_log_is_read_up_to_the_tear(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", [event("plant", n) for n in range(40)], flush_every=10)
    data = path.read_bytes()
    path.write_bytes(data[: third_chunk(data) + 30])
    run = LogPass(path)

    assert texts(run) == [f"plant 1 {n}" for n in range(20)]
    assert "cut off; its end is missing" in run.tear


@pytest.mark.parametrize("harm", [bytes(40), b""])
def test_a_pass_finds_the_next_chunk_after_a_damaged_length(tmp_path: Path, harm: bytes) -> None:
    path = write(tmp_path / "run.mcap", [event("plant", n) for n in range(40)], flush_every=10)
    data = path.read_bytes()
    for number in (0, 2):
        at = [at for at in range(len(data)) if data.startswith(b"\x28\xb5\x2f\xfd", at)][number]
        path.write_bytes(data[: at - 30] + harm + data[at + 10 :])
        run = LogPass(path)

        assert texts(run) == [f"plant 1 {n}" for n in range(40) if n // 10 != number]
        assert not run.finished


def test_a_log_without_chunks_is_read(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start()
        channel = writer.register_channel("passafe/robot/plant/event", "protobuf", 0)
        other = writer.register_channel("camera/image", "", 0)
        writer.add_message(channel, 0, encode(*event("plant", 0)), 0)
        writer.add_message(channel, 0, b"no message", 0)
        writer.add_message(other, 0, b"pixels", 0)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    run = LogPass(path)

    assert texts(run) == ["plant 1 0"]
    assert run.counts["event"].undecodable == 1
    assert run.foreign_keys == ["camera/image"]


def test_what_is_no_log_of_passafe_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.add_message(writer.register_channel("camera/image", "", 0), 0, b"pixels", 0)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated

    with pytest.raises(ForeignLogError, match="camera/image"):
        list(LogPass(path).slices({}))
    with pytest.raises(LogReadError, match="no such file"):
        LogPass(tmp_path / "missing.mcap")


@pytest.mark.timeout(20)
def test_a_pipe_is_refused_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.mcap"
    os.mkfifo(pipe)

    with pytest.raises(LogReadError, match="is a device or pipe, not a regular file"):
        LogPass(pipe)
    with pytest.raises(LogReadError, match="is a device or pipe, not a regular file"):
        LogPass(tmp_path)


def test_a_killed_worker_ends_the_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "run.mcap", [event("plant", n) for n in range(40)], flush_every=10)
    monkeypatch.setattr(log_pass, "STRETCH_BYTES", 1)
    receive = DecodingWorkers.receive

    def kill_and_receive(self: DecodingWorkers) -> object:
        self._processes[0].kill()
        self._processes[0].join()
        return receive(self)

    monkeypatch.setattr(DecodingWorkers, "receive", kill_and_receive)

    with pytest.raises(DecodingWorkerLostError, match="killed"):
        list(LogPass(path, workers=1).messages(Health))
