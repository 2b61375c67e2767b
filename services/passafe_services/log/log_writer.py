"""Writes the log of a run: unchanged wire bytes, one MCAP channel per key expression, the schema embedded.

The live recorder and the lockstep driver use the same writer, so their files have the same format.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, Literal, Self

from mcap.well_known import MessageEncoding, SchemaEncoding
from passafe_protocol.codec import file_descriptor_set, schema_name
from passafe_protocol.keys import parts_of
from passafe_protocol.topics import TOPIC_OF_NAME, Topic

from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.checkpoint import CHECKPOINT_RECORD, SIGNER_RECORD, record_digest
from passafe_services.log.log_file import LogFile
from passafe_services.log.log_files import RECORDING_RECORD
from passafe_services.log.manifest import Manifest, key_prefix, message_digest

SCENARIO_RECORD: Final = "scenario"
"""Metadata record with the effective configuration as JSON under ``json``."""
VERSIONS_RECORD: Final = "versions"
"""Metadata record with the versions of passafe and its numerical dependencies, by name."""
DRIVER_RECORD: Final = "driver"
"""Metadata record with ``kind``: live or lockstep, and ``planned_s`` if the run was to last for so long."""

MOST_IN_CHECKPOINT: Final = 4096
"""Messages after which a checkpoint is due, also without a flush."""
RECOVERED_RECORD: Final = "recovered"
"""Metadata record that marks a recovered log."""

SEQUENCE_MODULUS: Final = 2**32
TIME_LIMIT_NS: Final = 2**64

RunMetadata = Mapping[str, Mapping[str, str]]


def run_metadata(
    *,
    scenario_json: str,
    versions: Mapping[str, str],
    driver: Literal["live", "lockstep"],
    planned_s: float | None = None,
) -> dict[str, dict[str, str]]:
    """Return the metadata records of a run, for ``LogWriter``.

    Args:
        scenario_json: Effective configuration.
        versions: Versions of passafe and its numerical dependencies, by name.
        driver: What drives the nodes.
        planned_s: Plant time that the run is to last, s; ``None`` if it lasts until it is stopped.
    """
    json.loads(scenario_json)  # a log with an unreadable scenario would be useless
    return {
        SCENARIO_RECORD: {"json": scenario_json},
        VERSIONS_RECORD: dict(versions),
        DRIVER_RECORD: {"kind": driver} | ({} if planned_s is None else {"planned_s": repr(planned_s)}),
    }


def topic_of_key(key: str) -> Topic | None:
    """Return the topic of a key expression of passafe; ``None`` for any other key."""
    parts = parts_of(key)
    return None if parts is None else TOPIC_OF_NAME.get(parts.topic)


class LogWriter:
    """Log of one run; a context manager that finishes the file.

    A channel is registered at the first message of its key. A key of the topic table has message and schema encoding
    ``protobuf``; any other key is logged without a schema. Checkpoints attest the messages (see ``checkpoint``).

    Args:
        path: The file to write; an existing one is replaced.
        metadata: Metadata records of the file, by name (see ``run_metadata``).
        chain: Chain of the recording's checkpoints; if not given, the file is a recording of its own, not signed.
        part: Number of the file in the recording.
        channels: Key expressions of channels to register at once, in this order.

    Attributes:
        path: The file.
        messages: Messages written so far.
        channels: Number of every channel, by key expression.

    Raises:
        LogWriteError: The file cannot be created or written. Every method may raise it.
    """

    def __init__(
        self,
        path: Path,
        metadata: RunMetadata,
        *,
        chain: Chain | None = None,
        part: int = 1,
        channels: Sequence[str] = (),
    ) -> None:
        self.path = path
        self.messages = 0
        self.channels: dict[str, int] = {}
        self._part = part
        self._chain = Chain(_identity_of(metadata)) if chain is None else chain
        self._file = LogFile(path)
        self._schemas: dict[str, int] = {}
        self._prefixes: dict[str, bytes] = {}
        self._manifest = Manifest()
        self._counts = RecorderCounts()
        records = _with_recording(metadata, self._chain, part)
        self._metadata = {name: record_digest(record) for name, record in records.items()}
        with self._file.guarded():
            for name, record in records.items():
                self._file.mcap.add_metadata(name, dict(record))
            for key in channels:
                self._register(key)
        self._add_checkpoint()
        self._file.flush()

    @property
    def size_bytes(self) -> int:
        """Size of what is safe on the disk."""
        return self._file.size_bytes

    def write(self, key: str, data: bytes, *, sequence: int, wall_ns: int) -> None:
        """Log one message.

        Args:
            key: Key expression under which it was published; becomes the topic of the channel.
            data: Its wire bytes.
            sequence: ``sequence`` of its header; stored modulo 2³².
            wall_ns: ``wall_ns`` of its header, Unix time, not negative; stored as log time and publish time.
        """
        if not 0 <= wall_ns < TIME_LIMIT_NS:  # detected only when the chunk is written, it would lose the whole chunk
            raise ValueError(f"wall_ns: got {wall_ns}, allowed 0 to 2**64 - 1")
        channel = self.channels.get(key) or self._register(key)
        number = sequence % SEQUENCE_MODULUS
        try:
            self._file.mcap.add_message(
                channel_id=channel, log_time=wall_ns, data=data, publish_time=wall_ns, sequence=number
            )
        except OSError as error:
            raise self._file.failed(error) from error
        digest = message_digest(self._prefixes[key], number, wall_ns, wall_ns, data)
        self._manifest.add(channel, number, wall_ns, digest)
        self.messages += 1
        if len(self._manifest) >= MOST_IN_CHECKPOINT:
            self._add_checkpoint()

    def flush(self, counts: RecorderCounts | None = None) -> None:
        """Attest the messages written so far and synchronize them to disk, where they survive a crash.

        Args:
            counts: What the recorder knows of messages that are not in the log; as before if not given.
        """
        if self._note(counts) or len(self._manifest):
            self._add_checkpoint()
        self._file.flush()

    def close(self, counts: RecorderCounts | None = None, *, final: bool = True) -> None:
        """Finish the file; a second call has no effect.

        Args:
            counts: As for ``flush``.
            final: Whether the recording ends with this file.
        """
        if self._file.closed:
            return
        if self._note(counts) or len(self._manifest) or final:
            self._add_checkpoint(final=final)
        self._file.close()

    def _note(self, counts: RecorderCounts | None) -> bool:
        """Remember what the recorder knows; return whether that is news."""
        if counts is None or counts == self._counts:
            return False
        self._counts = counts
        return True

    def _add_checkpoint(self, *, final: bool = False) -> None:
        """Attest the messages since the last checkpoint, in whose chunk none may be that comes after this one."""
        record = self._chain.next_record(
            self._manifest,
            part=self._part,
            channels=self.channels,
            metadata=self._metadata,
            counts=self._counts,
            final=final,
        )
        self._manifest = Manifest()
        with self._file.guarded():
            self._file.mcap.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
            self._file.mcap.add_metadata(CHECKPOINT_RECORD, record)

    def _register(self, key: str) -> int:
        topic = topic_of_key(key)
        with self._file.guarded():
            if topic is None:
                channel = self._file.mcap.register_channel(key, "", 0)
            else:
                schema = self._schema(schema_name(topic))
                channel = self._file.mcap.register_channel(key, MessageEncoding.Protobuf, schema)
        self.channels[key] = channel
        self._prefixes[key] = key_prefix(key)
        return channel

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._file.mcap.register_schema(name, SchemaEncoding.Protobuf, file_descriptor_set())
        return self._schemas[name]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()


def _identity_of(metadata: RunMetadata) -> str:
    """Return the identity of a recording that follows from what it is of, so that equal runs have equal logs."""
    return record_digest({name: record_digest(record) for name, record in metadata.items()})[:32]


def _with_recording(metadata: RunMetadata, chain: Chain, part: int) -> dict[str, Mapping[str, str]]:
    """Return the metadata with the records of the recording and of who signs it."""
    records: dict[str, Mapping[str, str]] = {**metadata, RECORDING_RECORD: {"id": chain.recording, "part": str(part)}}
    if chain.signer is not None:
        records[SIGNER_RECORD] = {"certificate": chain.signer.certificate, "authority": chain.signer.authority}
    return records
