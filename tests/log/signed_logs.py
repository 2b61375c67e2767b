"""Signed logs, and logs whose records are changed with all checksums right."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path

from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec
from mcap.reader import make_reader
from mcap.records import Channel, Header, McapRecord, Message, Metadata, Schema
from mcap.writer import Writer
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, PlantPhase, PlantState
from passafe_protocol.messages import Header as WireHeader
from passafe_protocol.topics import EVENT, STATE
from passafe_services.keys.authority import Authority, KeyPair
from passafe_services.keys.signing import Signer
from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.log_reader import LogReader
from passafe_services.log.segmented_log import RawMessage, Rotation, SegmentedLog
from passafe_services.log.verification import Verification

S = 1_000_000_000
NOW_NS = (int(time.time()) + 3600) * S
"""Time at which the certificates of these tests are valid, however long after this line they are made."""
MESSAGES = 60
BETWEEN = 10


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
