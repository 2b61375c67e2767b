"""Messages logged and counted by the recorder."""

from pathlib import Path

import pytest
from mcap.reader import make_reader
from passafe_protocol.codec import MAX_MESSAGE_BYTES, encode
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    Event,
    Header,
    PlantPhase,
    PlantState,
    Receipt,
    RecordedSession,
    TopicHealth,
)
from passafe_protocol.sequence_window import MissingRange
from passafe_protocol.topics import EVENT, RECEIPT, STATE
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.wire_header import read_header
from passafe_services.recorder.message_recorder import OTHERS, MessageRecorder
from passafe_services.recorder.record_loop import HELD_UP

NOW_NS = 5_000_000


def event(sequence: int, *, source: str = "plant", epoch: int = 1, wall_ns: int = 1000) -> bytes:
    header = Header(source, epoch, sequence, 1, 2, 3, wall_ns)
    return encode(header, Event("info", f"number {sequence}"))


def recorded(
    tmp_path: Path, samples: list[tuple[str, bytes]]
) -> tuple[MessageRecorder, list[tuple[str, int, int, bytes]]]:
    path = tmp_path / "run.mcap"
    with LogWriter(path, {}) as log:
        recording = MessageRecorder(log)
        recording.record(samples, NOW_NS, 7)
    with path.open("rb") as stream:
        found = make_reader(stream).iter_messages(log_time_order=False)
        return recording, [(c.topic, m.sequence, m.log_time, m.data) for _, c, m in found]


def test_gaps_are_counted_per_key(tmp_path: Path) -> None:
    samples = [("passafe/robot/plant/event", event(k)) for k in (3, 4, 7)]
    samples += [("passafe/robot/filter/event", event(k, source="filter")) for k in (0, 2)]
    samples += [("passafe/robot/router/event", event(0, source="router"))]
    recording, _ = recorded(tmp_path, samples)
    assert recording.gaps() == {"passafe/robot/plant/event": 2, "passafe/robot/filter/event": 1}
    assert recording.health() == (TopicHealth("event", received=6, gaps=3, refused=0),)
    assert recording.bytes_recorded == sum(len(data) for _, data in samples)


def test_what_is_not_valid_is_logged_at_the_time_of_its_arrival(tmp_path: Path) -> None:
    key = EVENT.key("plant")
    good = event(0)
    other_version = good.replace(bytes((8, SCHEMA_VERSION)), bytes((8, SCHEMA_VERSION + 1)), 1)
    forged = event(1, source="filter")
    before_1970 = event(2, wall_ns=-1)
    bad = [good[:-1], b"", other_version, forged, before_1970]
    recording, found = recorded(tmp_path, [(key, data) for data in (good, *bad)])
    assert found == [(key, 0, 1000, good)] + [(key, 0, NOW_NS, data) for data in bad]
    assert recording.health() == (TopicHealth("event", received=1, gaps=0, refused=5),)


def test_duplicates_and_other_sessions_are_logged_and_counted(tmp_path: Path) -> None:
    key = EVENT.key("plant")
    samples = [event(0, epoch=2), event(1, epoch=2), event(1, epoch=2), event(9, epoch=2**64 - 1)]
    recording, found = recorded(tmp_path, [(key, data) for data in samples])
    assert [data for *_, data in found] == samples
    assert recording.health() == (TopicHealth("event", received=2, gaps=0, refused=2),)


@pytest.mark.parametrize("key", ["passafe/robot/plant/news", "passafe/robot/stranger/health", "passafe/a", "x"])
def test_other_keys_are_counted_and_not_logged(tmp_path: Path, key: str) -> None:
    recording, found = recorded(tmp_path, [(key, b"\x01\x02"), (EVENT.key("plant"), event(0))])
    assert [topic for topic, *_ in found] == [EVENT.key("plant")]
    assert recording.health() == (TopicHealth("event", 1, 0, 0), TopicHealth(OTHERS, 0, 0, refused=1))
    assert (recording.others, recording.last_other) == (1, f"2 bytes under {key}")


def test_a_hundred_thousand_keys_leave_the_log_whole(tmp_path: Path) -> None:
    strange = [(f"passafe/robot/k{k}/health", b"") for k in range(100_000)]
    recording, found = recorded(tmp_path, [*strange, (EVENT.key("plant"), event(0))])
    assert [topic for topic, *_ in found] == [EVENT.key("plant")]
    assert recording.others == 100_000
    assert len(recording._channels) == 1


def test_what_is_larger_than_a_message_is_not_logged(tmp_path: Path) -> None:
    key = EVENT.key("plant")
    recording, found = recorded(tmp_path, [(key, bytes(MAX_MESSAGE_BYTES)), (key, bytes(MAX_MESSAGE_BYTES + 1))])
    assert [len(data) for *_, data in found] == [MAX_MESSAGE_BYTES]
    assert recording.health() == (TopicHealth("event", 0, 0, 1), TopicHealth(OTHERS, 0, 0, 1))


def test_the_header_is_the_codecs() -> None:
    header = Header("plant", 9, 8, 7, 6, 5, 4)
    body = PlantState(3, (1.0, 2.0), (1.0,), (0.5,), 2, PlantPhase.RUNNING, 0.0, 1.0, 0, 0, 0, 0.0, 2)
    data = encode(header, body)
    assert read_header(STATE, data) == header


# Cut between two fields, at 10 and 16, the rest is a message too; protobuf has no end mark.
@pytest.mark.parametrize("length", [k for k in range(1, 20) if k not in {10, 16}])
def test_a_truncated_message_has_no_header(length: int) -> None:
    data = event(1)
    assert read_header(EVENT, data[:-length]) is None


def test_a_receipt_says_how_far_each_session_has_come(tmp_path: Path) -> None:
    samples = [(EVENT.key("plant"), event(k)) for k in (3, 7, 4)]
    samples += [(EVENT.key("filter"), event(0, source="filter", epoch=9))]
    recording, _ = recorded(tmp_path, samples)

    assert recording.receipt(lambda _, __: False) == Receipt(
        (RecordedSession("plant", "event", 1, 7), RecordedSession("filter", "event", 9, 0))
    )


def test_its_own_receipts_are_not_logged(tmp_path: Path) -> None:
    data = encode(Header("recorder", 1, 0, 1, 2, 3, 4), Receipt(()))
    recording, found = recorded(tmp_path, [(RECEIPT.key("recorder"), data), (RECEIPT.key("plant"), data)])

    assert found == []
    assert (recording.others, recording.last_other) == (1, f"{len(data)} bytes under {RECEIPT.key('plant')}")


def test_only_what_is_missing_is_logged_from_a_cache(tmp_path: Path) -> None:
    key, other = EVENT.key("plant"), EVENT.key("filter")
    with LogWriter(tmp_path / "run.mcap", {}) as log:
        recording = MessageRecorder(log)
        recording.record([(key, event(k)) for k in (3, 4, 7, 9)], NOW_NS, 7)
        assert recording.missing() == {key: [MissingRange(1, 5, 6), MissingRange(1, 8, 8)]}

        answer = [event(4), event(6), event(6), event(5, epoch=2), event(7), event(9), b"damaged"]
        recording.record_missed([*((key, data) for data in answer), (other, event(0, source="filter"))], NOW_NS, 8)

        assert recording.missing() == {key: [MissingRange(1, 5, 5), MissingRange(1, 8, 8)]}
        assert recording.health() == (TopicHealth("event", received=5, gaps=2, refused=0),)


def test_a_receipt_ends_before_what_is_waited_for(tmp_path: Path) -> None:
    key = EVENT.key("plant")
    with LogWriter(tmp_path / "run.mcap", {}) as log:
        recording = MessageRecorder(log)
        recording.record([(key, event(k)) for k in (3, 4, 7, 9)], NOW_NS, 7)

    def newest(*given_up: int) -> int:
        [session] = recording.receipt(lambda _, missing: missing.first not in given_up).sessions
        return session.newest

    assert (newest(), newest(5), newest(5, 8)) == (4, 7, 9)


def test_what_was_held_up_on_its_way_is_believed(tmp_path: Path) -> None:
    key = EVENT.key("plant")
    with LogWriter(tmp_path / "run.mcap", {}) as log:
        recording = MessageRecorder(log, HELD_UP)
        for number in (0, 1, 1_500):
            recording.record([(key, event(number))], NOW_NS, 7)

    assert recording.missing() == {key: [MissingRange(1, 2, 1_499)]}
