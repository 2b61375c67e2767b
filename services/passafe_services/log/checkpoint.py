"""Checkpoint of a log: a metadata record that attests the messages since the one before, and what is missing."""

from base64 import b64decode, b64encode
from collections.abc import Mapping
from hashlib import sha256
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, NonNegativeInt, ValidationError

CHECKPOINT_RECORD: Final = "checkpoint"
"""Metadata record with a checkpoint as JSON under ``body`` and the signature of these bytes under ``signature``."""
MOST_ATTESTED: Final = 2**20
"""Messages that one checkpoint may attest; a reader takes the memory for them on its word."""
SIGNER_RECORD: Final = "signer"
"""Metadata record with the ``certificate`` of the key that signs the checkpoints, and of its ``authority``, PEM."""


class KeyCount(BaseModel):
    """Messages of one key expression so far, over all files of a recording.

    Attributes:
        written: Messages logged.
        gaps: Sequence numbers never received between others.
        lost: Messages that were received and not logged, since the disk was full or too slow.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    written: NonNegativeInt = 0
    gaps: NonNegativeInt = 0
    lost: NonNegativeInt = 0


class Checkpoint(BaseModel):
    """Statement of the recorder on its log at one moment.

    Attributes:
        recording: Identity of the recording, the same in all of its files.
        part: Number of the file in the recording, from 1.
        number: Number of the checkpoint in the recording, from 0.
        wall_ns: Log time of the newest message, Unix time, ns; 0 before the first.
        final: Whether the recording ends here.
        channels: Key expression of every channel so far, by its number.
        counts: Messages so far, by key expression.
        metadata: SHA-256 of the other metadata records of the file, by their name.
        messages: Messages since the checkpoint before.
        manifest: Each of these in short, see ``manifest``.
        digest: SHA-256 of their digests in order.
        previous: SHA-256 of the body of the checkpoint before; empty in the first.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    recording: str
    part: NonNegativeInt
    number: NonNegativeInt
    wall_ns: NonNegativeInt
    final: bool
    channels: dict[int, str]
    counts: dict[str, KeyCount]
    metadata: dict[str, str]
    messages: Annotated[int, Field(ge=0, le=MOST_ATTESTED)]
    manifest: str
    digest: str
    previous: str


def checkpoint_of(record: Mapping[str, str]) -> Checkpoint | None:
    """Return the checkpoint in a metadata record; ``None`` if it is damaged."""
    try:
        return Checkpoint.model_validate_json(record.get("body", ""))
    except ValidationError:
        return None


def checkpoint_record(body: str, signature: bytes) -> dict[str, str]:
    """Return the metadata record with a checkpoint.

    Args:
        body: The checkpoint as JSON.
        signature: Signature of these bytes; empty without one.
    """
    return {"body": body, "signature": b64encode(signature).decode()}


def signature_of(record: Mapping[str, str]) -> bytes:
    """Return the signature in the metadata record of a checkpoint; empty without one or if it is damaged."""
    try:
        return b64decode(record.get("signature", ""), validate=True)
    except ValueError:
        return b""


def body_digest(body: str) -> str:
    """Return what the next checkpoint names as ``previous``."""
    return sha256(body.encode()).hexdigest()


def record_digest(record: Mapping[str, str]) -> str:
    """Return the SHA-256 of a metadata record: of its pairs, each with lengths before key and value, sorted by key."""
    digest = sha256()
    for pair in sorted(record.items()):
        for text in pair:
            data = text.encode()
            digest.update(len(data).to_bytes(8, "little") + data)
    return digest.hexdigest()
