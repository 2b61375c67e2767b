"""Writes the log of a run: unchanged wire bytes, one MCAP channel per key expression, the schema embedded.

The live recorder and the lockstep driver use the same writer, so their files have the same format.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal, Self

from mcap.well_known import MessageEncoding, SchemaEncoding
from passafe_protocol.codec import file_descriptor_set, schema_name
from passafe_protocol.keys import parts_of
from passafe_protocol.topics import TOPIC_OF_NAME, Topic

from passafe_services.log.log_file import LogFile

SCENARIO_RECORD: Final = "scenario"
"""Metadata record with the effective configuration as JSON under ``json``."""
VERSIONS_RECORD: Final = "versions"
"""Metadata record with the versions of passafe and its numerical dependencies, by name."""
DRIVER_RECORD: Final = "driver"
"""Metadata record with ``kind``: live or lockstep, and ``planned_s`` if the run was to last for so long."""

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
    ``protobuf``; any other key is logged without a schema.

    Args:
        path: The file to write; an existing one is replaced.
        metadata: Metadata records of the file, by name (see ``run_metadata``).

    Attributes:
        path: The file.
        messages: Messages written so far.

    Raises:
        LogWriteError: The file cannot be created or written. Every method may raise it.
    """

    def __init__(self, path: Path, metadata: RunMetadata) -> None:
        self.path = path
        self.messages = 0
        self._file = LogFile(path)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        with self._file.guarded():
            for name, record in metadata.items():
                self._file.mcap.add_metadata(name, dict(record))
        self._file.flush()

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
        channel = self._channels.get(key) or self._register(key)
        try:
            self._file.mcap.add_message(
                channel_id=channel,
                log_time=wall_ns,
                data=data,
                publish_time=wall_ns,
                sequence=sequence % SEQUENCE_MODULUS,
            )
        except OSError as error:
            raise self._file.failed(error) from error
        self.messages += 1

    def flush(self) -> None:
        """Synchronize the messages written so far to disk, where they survive a crash."""
        self._file.flush()

    def close(self) -> None:
        """Finish the file; a second call has no effect."""
        self._file.close()

    def _register(self, key: str) -> int:
        topic = topic_of_key(key)
        with self._file.guarded():
            if topic is None:
                channel = self._file.mcap.register_channel(key, "", 0)
            else:
                schema = self._schema(schema_name(topic))
                channel = self._file.mcap.register_channel(key, MessageEncoding.Protobuf, schema)
        self._channels[key] = channel
        return channel

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            self._schemas[name] = self._file.mcap.register_schema(name, SchemaEncoding.Protobuf, file_descriptor_set())
        return self._schemas[name]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()
