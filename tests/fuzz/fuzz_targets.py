"""Everything that reads bytes of others, as functions of bytes, with the files that mutations start from."""

import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from passafe_protocol.codec import decode
from passafe_protocol.errors import DecodeError
from passafe_protocol.topics import TOPICS
from passafe_services.log.verification import verify
from passafe_services.log.wire_header import read_header
from passafe_services.operator.sources.command_recording import load_recording
from passafe_services.scenarios.link_trace import read_trace
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.load import load_study
from passafe_services.tools.recover import recover
from passafe_services.tools.review.run_log import RunLog

from passafe.errors import PassafeError

CORPUS = Path(__file__).parent / "corpus"
"""Folder of each target: small valid files, and inputs that once did harm."""


class FuzzTarget(NamedTuple):
    """Reader of a file.

    Attributes:
        suffix: Suffix that the file must have.
        read: Reads it; may raise ``PassafeError`` only.
    """

    suffix: str
    read: Callable[[Path], object]


def decode_on_every_topic(path: Path) -> None:
    """Decode the bytes as a message of each topic.

    Raises:
        DecodeError: They are a message of none.
    """
    data = path.read_bytes()
    accepted = 0
    for topic in TOPICS:
        read_header(topic, data)
        with suppress(PassafeError):
            decode(topic, data)
            accepted += 1
    if not accepted:
        raise DecodeError("any", len(data), "of no topic")


def read_log(path: Path) -> None:
    """Recover the log, and read it as a review would."""
    with suppress(PassafeError):
        recover(path, path.with_suffix(".recovered.mcap"))
    with suppress(PassafeError):
        verify(path)
    RunLog.read(path)


TARGETS = {
    "codec": FuzzTarget(".bin", decode_on_every_topic),
    "scenario": FuzzTarget(".toml", lambda path: load_scenario(str(path))),
    "scenario-json": FuzzTarget(".json", lambda path: load_scenario(str(path))),
    "experiment": FuzzTarget(".toml", lambda path: load_study(str(path))),
    "link-trace": FuzzTarget(".csv", read_trace),
    "recording": FuzzTarget(".csv", lambda path: load_recording(path, 2)),
    "log": FuzzTarget(".mcap", read_log),
}


def with_checksum(body: bytes) -> bytes:
    """Return a message without its last field, the checksum, completed by it."""
    return body + b"\x9d\x06" + zlib.crc32(body).to_bytes(4, "little")


def corpus_of(name: str) -> list[bytes]:
    """Return the kept inputs of a target, sorted by name."""
    return [path.read_bytes() for path in sorted((CORPUS / name).iterdir())]


def survives(name: str, data: bytes, folder: Path) -> bool:
    """Return whether the target accepts the bytes; any error but ``PassafeError`` is raised.

    Args:
        name: The target.
        data: Contents of the file.
        folder: Where the file is written.
    """
    path = folder / f"input{TARGETS[name].suffix}"
    path.write_bytes(data)
    try:
        TARGETS[name].read(path)
    except PassafeError:
        return False
    return True
