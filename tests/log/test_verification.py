"""Verified logs: whatever is changed after the recorder wrote it is found and named, checksums recomputed or not."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec
from mcap.reader import make_reader
from mcap.records import Channel, Header, McapRecord, Message, Metadata, Schema
from mcap.writer import Writer
from passafe_protocol.codec import decode, encode
from passafe_protocol.identity import Identity
from passafe_protocol.messages import Event, PlantPhase, PlantState
from passafe_protocol.messages import Header as WireHeader
from passafe_protocol.topics import EVENT, STATE
from passafe_services.keys.authority import Authority, KeyPair
from passafe_services.keys.signing import Signer
from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.log_files import files_of
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.segmented_log import RawMessage, Rotation, SegmentedLog
from passafe_services.log.verification import Verification, verify
from passafe_services.tools.recover import recover

S = 1_000_000_000
NOW_NS = (int(time.time()) + 3600) * S
"""Time at which the certificates of these tests are valid, however long after this line they are made."""
MESSAGES = 60
BETWEEN = 10


@pytest.fixture(scope="module")
def authority() -> Authority:
    return Authority.create(days=3650)


@pytest.fixture(scope="module")
def pair(authority: Authority) -> KeyPair:
    return authority.issue(Identity(role="recorder", robot="robot"), days=3650)


def signer_of(pair: KeyPair, authority: Authority) -> Signer:
    key = serialization.load_pem_private_key(pair.key, password=None)
    assert isinstance(key, ec.EllipticCurvePrivateKey)
    return Signer(key, certificate=pair.certificate.decode(), authority=authority.pair.certificate.decode())


def state(k: int) -> RawMessage:
    header = WireHeader("plant", 1, k, 0, 0, 0, NOW_NS + k * S)
    body = PlantState(k, (1.0, 2.0), (1.0,), (0.5,), 2, PlantPhase.RUNNING, 0.0, 1.0, 0, 0, 0, 0.0, 2)
    return RawMessage(STATE.key("plant"), encode(header, body), k, header.wall_ns)


def event(k: int) -> RawMessage:
    header = WireHeader("plant", 1, k, 0, 0, 0, NOW_NS + k * S)
    return RawMessage(EVENT.key("plant"), encode(header, Event("info", f"number {k}")), k, header.wall_ns)


def record(path: Path, signer: Signer | None, rotation: Rotation | None = None) -> None:
    chain = Chain("a recording", signer)
    log = SegmentedLog(path, {"driver": {"kind": "live"}}, chain, rotation=rotation)
    for k in range(MESSAGES):
        log.write(state(k))
        if k % 3 == 0:
            log.write(event(k // 3))
        if k % BETWEEN == BETWEEN - 1:
            log.flush(RecorderCounts())
    log.close(RecorderCounts())


@pytest.fixture
def log(tmp_path: Path, pair: KeyPair, authority: Authority) -> Path:
    path = tmp_path / "run.mcap"
    record(path, signer_of(pair, authority))
    return path


@pytest.fixture
def pinned(tmp_path: Path, authority: Authority) -> Path:
    path = tmp_path / "ca.pem"
    path.write_bytes(authority.pair.certificate)
    return path


def rewritten(path: Path, change: Callable[[list[McapRecord]], Iterable[McapRecord]]) -> None:
    """Write a file anew with other records: every checksum and index is right."""
    records = list(LogReader(path, alone=True).records())
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(library="passafe")
        known: set[tuple[type, int]] = set()
        for each in change(records):
            match each:
                case Schema() if (Schema, each.id) not in known:
                    known.add((Schema, each.id))
                    writer.register_schema(each.name, each.encoding, each.data)
                case Channel() if (Channel, each.id) not in known:
                    known.add((Channel, each.id))
                    writer.register_channel(each.topic, each.message_encoding, each.schema_id, each.metadata)
                case Message():
                    times = each.publish_time, each.sequence
                    writer.add_message(each.channel_id, each.log_time, each.data, *times)
                case Metadata():
                    writer.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
                    writer.add_metadata(each.name, each.metadata)
                case Header():
                    pass
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    with path.open("rb") as stream:
        assert list(make_reader(stream, validate_crcs=True).iter_messages())


def states(records: list[McapRecord]) -> list[int]:
    """Return the places of the states."""
    [number] = {each.id for each in records if isinstance(each, Channel) and each.topic == STATE.key("plant")}
    return [k for k, each in enumerate(records) if isinstance(each, Message) and each.channel_id == number]


def named(found: Verification) -> list[tuple[str, str, int, int]]:
    return [(each.change, each.key, each.sequence, (each.wall_ns - NOW_NS) // S) for each in found.found]


def test_a_signed_log_verifies(log: Path, pinned: Path) -> None:
    found = verify(log, pinned)
    assert (found.holds, found.doubts, found.found) == (True, [], [])
    assert (found.messages, found.attested, found.unattested) == (80, 80, 0)
    assert (found.signer, found.is_pinned) == ("recorder.robot", True)
    assert not verify(log).is_pinned


@pytest.mark.parametrize("which", [0, 9, 10, 33, 59])
def test_a_changed_float_is_named(log: Path, pinned: Path, which: int) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        message: Any = records[states(records)[which]]
        header, body = decode(STATE, message.data)
        message.data = encode(header, replace_x(body))
        return records

    rewritten(log, change)
    found = verify(log, pinned)
    assert not found.holds
    assert named(found) == [("changed", STATE.key("plant"), which, which)]
    assert found.attested == 79


def replace_x(body: object) -> PlantState:
    """Return a state with one float changed by the last bit."""
    assert isinstance(body, PlantState)
    return msgspec.structs.replace(body, x=(1.0000000000000002, 2.0))


def test_a_message_left_out_is_named(log: Path, pinned: Path) -> None:
    rewritten(log, lambda records: [each for k, each in enumerate(records) if k != states(records)[17]])
    found = verify(log, pinned)
    assert named(found) == [("left out", STATE.key("plant"), 17, 17)]


def test_swapped_messages_are_named(log: Path, pinned: Path) -> None:
    def swap(records: list[McapRecord]) -> list[McapRecord]:
        one, other = states(records)[21], states(records)[22]
        records[one], records[other] = records[other], records[one]
        return records

    rewritten(log, swap)
    assert named(verify(log, pinned)) == [("moved", STATE.key("plant"), k, k) for k in (21, 22)]


def test_a_swap_over_a_checkpoint_is_named(log: Path, pinned: Path) -> None:
    def swap(records: list[McapRecord]) -> list[McapRecord]:
        one, other = states(records)[19], states(records)[20]
        records[one], records[other] = records[other], records[one]
        return records

    rewritten(log, swap)
    assert {(change, sequence) for change, _, sequence, _ in named(verify(log, pinned))} == {
        ("left out", 19),
        ("left out", 20),
        ("added", 19),
        ("added", 20),
    }


def test_an_added_message_is_named(log: Path, pinned: Path) -> None:
    rewritten(log, lambda records: [*records[: states(records)[5]], *records[states(records)[4] :]])
    assert named(verify(log, pinned)) == [("added", STATE.key("plant"), 4, 4)]


def test_moved_messages_are_as_few_as_can_be(log: Path, pinned: Path) -> None:
    def move(records: list[McapRecord]) -> list[McapRecord]:
        places = states(records)
        records.insert(places[38], records.pop(places[31]))
        return records

    rewritten(log, move)
    assert named(verify(log, pinned)) == [("moved", STATE.key("plant"), 31, 31)]


@pytest.mark.parametrize("first", [Metadata, Message])
def test_a_log_that_a_tool_wrote_anew_is_compared_by_message(log: Path, pinned: Path, first: type) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        del records[states(records)[44]]
        message: Any = records[states(records)[33]]
        header, body = decode(STATE, message.data)
        message.data = encode(header, replace_x(body))
        messages = [each for each in records if isinstance(each, Message)]
        messages.sort(key=lambda each: (each.log_time, -each.channel_id))
        metadata = [each for each in records if isinstance(each, Metadata)]
        others = [each for each in records if isinstance(each, Schema | Channel)]
        return [*others, *metadata, *messages] if first is Metadata else [*others, *messages, *metadata]

    rewritten(log, change)
    found = verify(log, pinned)
    assert named(found) == [("changed", STATE.key("plant"), 33, 33), ("left out", STATE.key("plant"), 44, 44)]
    assert found.attested == 78
    assert any("it was written anew" in doubt for doubt in found.doubts)


def test_changed_metadata_is_named(log: Path, pinned: Path) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        for each in records:
            if isinstance(each, Metadata) and each.name == "driver":
                each.metadata = {"kind": "lockstep"}
        return records

    rewritten(log, change)
    assert verify(log, pinned).doubts == ["metadata record driver is not as it was written"]
    assert recover(log, log.with_name("out.mcap")).altered == ("driver",)


def is_checkpoint(record: McapRecord) -> bool:
    return isinstance(record, Metadata) and record.name == "checkpoint"


def test_a_checkpoint_left_out_is_named(log: Path, pinned: Path) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        del records[[k for k, each in enumerate(records) if is_checkpoint(each)][3]]
        return records

    rewritten(log, change)
    found = verify(log, pinned)
    assert not found.holds
    assert "checkpoints 3 to 3 are missing" in found.doubts
    assert {change for change, *_ in named(found)} == {"added"}


def test_checkpoints_computed_anew_are_not_signed(log: Path, pinned: Path, tmp_path: Path) -> None:
    forged = tmp_path / "forged.mcap"
    record(forged, None)

    def with_signer(records: list[McapRecord]) -> list[McapRecord]:
        [of_signer] = [
            each for each in LogReader(log).records() if isinstance(each, Metadata) and each.name == "signer"
        ]
        return [records[0], of_signer, *records[1:]]

    rewritten(forged, with_signer)
    found = verify(forged, pinned)
    assert not found.holds
    assert found.attested == 0
    assert "checkpoints without a valid signature: 8, the first 0" in found.doubts


def test_a_log_without_keys_is_not_verified(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, None)
    found = verify(path)
    assert (found.holds, found.found) == (False, [])
    assert found.doubts == ["it is not signed: whoever can write the file can compute its checkpoints anew"]


def test_a_signature_of_another_authority_is_no_proof(log: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.pem"
    other.write_bytes(Authority.create(days=1).pair.certificate)
    found = verify(log, other)
    assert not found.holds
    assert "is not of the authority" in found.doubts[0]


def test_the_recorders_certificate_may_be_pinned(log: Path, tmp_path: Path, pair: KeyPair) -> None:
    path = tmp_path / "recorder.pem"
    path.write_bytes(pair.certificate)
    assert verify(log, path).holds


def test_another_roles_signature_is_no_proof(tmp_path: Path, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, signer_of(authority.issue(Identity(role="plant", robot="robot"), days=3650), authority))
    assert verify(path, pinned).doubts == ["it is signed by plant.robot, which is no recorder"]


def test_a_certificate_that_had_expired_is_no_proof(tmp_path: Path, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    days = (NOW_NS / S + 25 - time.time()) / 86_400
    record(path, signer_of(authority.issue(Identity(role="recorder", robot="robot"), days=days), authority))
    found = verify(path, pinned)
    assert 10 <= found.attested <= 40
    assert any("checkpoints without a valid signature" in doubt for doubt in found.doubts)


def test_a_torn_log_verifies_up_to_its_last_checkpoint(
    tmp_path: Path, pair: KeyPair, authority: Authority, pinned: Path
) -> None:
    path, torn, out = (tmp_path / name for name in ("run.mcap", "torn.mcap", "out.mcap"))
    record(path, signer_of(pair, authority))
    torn.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found = verify(torn, pinned)
    assert 0 < found.attested < 80
    assert found.found == []
    assert any("the end is missing" in doubt for doubt in found.doubts)
    recover(torn, out)
    again = verify(out, pinned)
    assert (again.attested, again.found) == (found.attested, [])


def test_messages_after_the_last_checkpoint_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    writer = LogWriter(path, {})
    for k in range(5):
        writer.write(*state(k)[:2], sequence=k, wall_ns=state(k).wall_ns)
    writer._file.flush()
    found = verify(path)
    writer.close()
    assert (found.unattested, found.unattested_from_ns) == (5, NOW_NS)
    assert "5 messages after the last checkpoint are not attested" in found.doubts


def test_a_chain_goes_over_rotated_files(tmp_path: Path, pair: KeyPair, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, signer_of(pair, authority), Rotation(size_bytes=6000))
    files = files_of(path)
    assert len(files) > 2
    assert verify(path, pinned).holds
    files[1].unlink()
    found = verify(path, pinned)
    assert not found.holds
    assert any("are missing" in doubt for doubt in found.doubts)


def test_damage_is_reported_and_its_messages_named(log: Path, pinned: Path, tmp_path: Path) -> None:
    content = bytearray(log.read_bytes())
    chunks = [at for at in range(len(content)) if content.startswith(b"\x28\xb5\x2f\xfd", at)]
    content[chunks[2] + 40] ^= 1
    log.write_bytes(content)
    for path in (log, tmp_path / "out.mcap"):
        if path != log:
            recover(log, path)
        found = verify(path, pinned)
        assert {change for change, *_ in named(found)} == {"left out"}
        assert [sequence for _, key, sequence, _ in named(found) if key == STATE.key("plant")] == list(range(20, 30))


def test_a_log_of_before_has_no_checkpoints(tmp_path: Path) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    assert verify(path).doubts == ["it has no checkpoints: it was written before there were any, or by another program"]
