"""Logs of LogWriter, read back byte for byte by the standard reader."""

import errno
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, Health, TopicHealth
from passafe_protocol.topics import EVENT, HEALTH, STATE
from passafe_services.log.checkpoint import CHECKPOINT_RECORD
from passafe_services.log.errors import LogWriteError
from passafe_services.log.log_files import RECORDING_RECORD
from passafe_services.log.log_writer import LogWriter, run_metadata, topic_of_key

WALL_NS = 1_763_800_000_000_000_000


def header(source: str, sequence: int) -> Header:
    return Header(source, 1, sequence, 10, 11, 12, WALL_NS + sequence)


def test_the_standard_reader_and_decoder_read_it(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    health = Health(50.0, 3, 2, 1, 0.5, (TopicHealth("state", 5, 4, 3),))
    metadata = run_metadata(scenario_json='{"name": "x"}', versions={"mcap": "1.6"}, driver="live")
    wire = {}
    with LogWriter(path, metadata) as log:
        for source in ("plant", "filter"):
            for sequence in range(3):
                body = health if sequence == 2 else Event("info", f"{source} {sequence}")
                topic = HEALTH if sequence == 2 else EVENT
                data = encode(header(source, sequence), body)
                wire[topic.key(source), sequence] = data
                log.write(topic.key(source), data, sequence=sequence, wall_ns=WALL_NS + sequence)
        assert log.messages == 6
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        found = {}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert schema is not None
            assert schema.encoding == channel.message_encoding == "protobuf"
            assert schema.name == f"passafe.v1.{type(decoded).__name__}"
            assert message.log_time == message.publish_time == WALL_NS + message.sequence
            assert decoded.header.source == channel.topic.split("/")[2]
            assert decoded.header.sequence == message.sequence
            found[channel.topic, message.sequence] = message.data
            if channel.topic == "passafe/robot/plant/health":
                assert decoded.topics[0].gaps == 4
        assert found == wire
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 6
        assert sorted(schema.name for schema in summary.schemas.values()) == [
            "passafe.v1.Event",
            "passafe.v1.Health",
        ]
        assert {
            record.name: record.metadata
            for record in reader.iter_metadata()
            if record.name not in {CHECKPOINT_RECORD, RECORDING_RECORD}
        } == {
            "scenario": {"json": '{"name": "x"}'},
            "versions": {"mcap": "1.6"},
            "driver": {"kind": "live"},
        }


def test_the_sequence_wraps_at_32_bits(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path, {}) as log:
        log.write("passafe/robot/plant/event", b"", sequence=2**32 + 7, wall_ns=0)
    with path.open("rb") as stream:
        assert [m.sequence for _, _, m in make_reader(stream).iter_messages()] == [7]


@pytest.mark.parametrize("wall_ns", [-1, 2**64])
def test_time_out_of_range_is_refused_before_it_reaches_a_chunk(tmp_path: Path, wall_ns: int) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path, {}) as log:
        with pytest.raises(ValueError, match="wall_ns"):
            log.write("passafe/robot/plant/event", b"", sequence=0, wall_ns=wall_ns)
        log.write("passafe/robot/plant/event", b"x", sequence=0, wall_ns=5)
    with path.open("rb") as stream:
        assert [m.data for _, _, m in make_reader(stream).iter_messages()] == [b"x"]


def test_unknown_key_is_logged_without_a_schema(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path, {}) as log:
        log.write("passafe/robot/plant/unheard_of", b"\x01", sequence=0, wall_ns=0)
    with path.open("rb") as stream:
        [(schema, channel, message)] = make_reader(stream).iter_messages()
    assert schema is None
    assert (channel.topic, channel.message_encoding, message.data) == (
        "passafe/robot/plant/unheard_of",
        "",
        b"\x01",
    )


@pytest.mark.parametrize(
    "key", ["passafe/robot/plant/state/more", "passafe/state", "other/plant/state", "state", "passafe/robot/plant/x"]
)
def test_keys_without_a_topic(key: str) -> None:
    assert topic_of_key(key) is None
    assert topic_of_key(EVENT.key("plant")) is EVENT


def test_keys_of_logs_without_robot_are_known() -> None:
    assert topic_of_key("passafe/plant/state") is STATE


def test_nothing_is_written_after_the_end(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    log = LogWriter(path, {})
    log.close()
    size = path.stat().st_size
    log.close()
    assert path.stat().st_size == size


def test_a_scenario_that_is_no_json_is_refused() -> None:
    with pytest.raises(ValueError, match="Expecting"):
        run_metadata(scenario_json="name = 'x'", versions={}, driver="live")


@pytest.mark.parametrize(
    ("place", "reason"),
    [("missing/run.mcap", "No such file"), ("file/run.mcap", "Not a directory"), (".", "Is a directory")],
)
def test_unwritable_path_is_reported_in_one_line(tmp_path: Path, place: str, reason: str) -> None:
    (tmp_path / "file").touch()
    path = tmp_path / place
    with pytest.raises(LogWriteError, match=reason) as caught:
        LogWriter(path, {})
    assert str(caught.value).startswith(f"{path}: cannot write the log: ")
    assert "\n" not in str(caught.value)


NO_PERMISSION = """
import os, sys
from pathlib import Path
from passafe_services.log.errors import LogWriteError
from passafe_services.log.log_writer import LogWriter
folder = Path(sys.argv[1])
folder.chmod(0o500)
if os.geteuid() == 0:
    os.seteuid(65534)
try:
    LogWriter(folder / "run.mcap", {})
except LogWriteError as error:
    sys.exit(str(error))
"""


def test_folder_without_permission_is_reported_in_one_line(tmp_path: Path) -> None:
    folder = tmp_path / "closed"
    folder.mkdir()
    child = subprocess.run(
        [sys.executable, "-c", NO_PERMISSION, str(folder)],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[2],
    )
    assert child.returncode == 1
    assert child.stderr == f"{folder / 'run.mcap'}: cannot write the log: Permission denied\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_a_typed_error_at_once(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.symlink_to("/dev/full")
    with pytest.raises(LogWriteError, match="No space left on device") as caught:
        LogWriter(path, {})
    assert caught.value.errno == errno.ENOSPC


@pytest.mark.parametrize("how", ["removed", "moved", "replaced", "folder removed"])
def test_log_that_is_taken_away_is_an_error_at_once(how: str, tmp_path: Path) -> None:
    path = tmp_path / "runs" / "run.mcap"
    path.parent.mkdir()
    log = LogWriter(path, run_metadata(scenario_json="{}", versions={}, driver="live"))
    match how:
        case "moved":
            path.rename(tmp_path / "other.mcap")
        case "replaced":
            (tmp_path / "other.mcap").write_bytes(b"x")
            (tmp_path / "other.mcap").rename(path)
        case _:
            path.unlink()
            if how == "folder removed":
                path.parent.rmdir()

    with pytest.raises(LogWriteError, match="it was removed, moved or replaced while it was written") as gone:
        log.flush()
    assert gone.value.errno == errno.ENOENT


def test_log_that_is_gone_at_the_end_is_not_finished(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    log = LogWriter(path, run_metadata(scenario_json="{}", versions={}, driver="live"))
    path.unlink()

    with pytest.raises(LogWriteError, match="removed"):
        log.close()
