"""Chain of the checkpoints of a recording, over all of its files."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from passafe_services.log.checkpoint import Checkpoint, KeyCount, body_digest, checkpoint_record
from passafe_services.log.manifest import Manifest


class CheckpointSigner(Protocol):
    """Signs checkpoints, such as ``passafe_services.keys.signing.Signer``."""

    certificate: str
    authority: str

    def sign(self, data: bytes) -> bytes:
        """Return the signature of some bytes."""
        ...


@dataclass(frozen=True, kw_only=True, slots=True)
class RecorderCounts:
    """Counts of messages that a recorder knows of and that are not in its log, by key expression.

    Attributes:
        gaps: Sequence numbers never received between others.
        lost: Messages that were received and not logged.
    """

    gaps: Mapping[str, int] = field(default_factory=dict)
    lost: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, slots=True)
class ChainEnd:
    """End of a chain, which the next checkpoint continues.

    Attributes:
        number: Number of the next checkpoint.
        previous: Digest of the last one; empty before the first.
        newest_ns: Log time of the newest message, ns.
        written: Messages logged so far, by key expression.
    """

    number: int = 0
    previous: str = ""
    newest_ns: int = 0
    written: Mapping[str, int] = field(default_factory=dict)


class Chain:
    """Chain of the checkpoints of one recording.

    Args:
        recording: Identity of the recording.
        signer: Signs the checkpoints; ``None``: they are not signed.

    Attributes:
        recording: As given.
        signer: As given.
        end: End of the chain; assign an earlier one to drop checkpoints that did not reach the disk.
    """

    def __init__(self, recording: str, signer: CheckpointSigner | None = None) -> None:
        self.recording = recording
        self.signer = signer
        self.end = ChainEnd()

    def next_record(
        self,
        manifest: Manifest,
        *,
        part: int,
        channels: Mapping[str, int],
        metadata: Mapping[str, str],
        counts: RecorderCounts,
        final: bool,
    ) -> dict[str, str]:
        """Return the metadata record of the next checkpoint, and move the end of the chain there.

        Args:
            manifest: Messages since the last checkpoint.
            part: Number of the file.
            channels: Number of every channel, by key expression.
            metadata: SHA-256 of the other metadata records of the file, by name.
            counts: What the recorder knows of messages that are not in the log.
            final: Whether the recording ends here.
        """
        end, written = self.end, dict(self.end.written)
        keys = {number: key for key, number in channels.items()}
        for number, messages in Counter(manifest.channels).items():
            written[keys[number]] = written.get(keys[number], 0) + messages
        newest_ns = max(end.newest_ns, manifest.newest_ns)
        body = Checkpoint(
            recording=self.recording,
            part=part,
            number=end.number,
            wall_ns=newest_ns,
            final=final,
            channels=keys,
            counts=_key_counts((*written, *counts.gaps, *counts.lost), written, counts),
            metadata=dict(metadata),
            messages=len(manifest),
            manifest=manifest.text,
            digest=manifest.digest,
            previous=end.previous,
        ).model_dump_json()
        self.end = replace(end, number=end.number + 1, previous=body_digest(body), newest_ns=newest_ns, written=written)
        return checkpoint_record(body, b"" if self.signer is None else self.signer.sign(body.encode()))


def _key_counts(keys: Iterable[str], written: Mapping[str, int], counts: RecorderCounts) -> dict[str, KeyCount]:
    return {
        key: KeyCount(written=written.get(key, 0), gaps=counts.gaps.get(key, 0), lost=counts.lost.get(key, 0))
        for key in dict.fromkeys(keys)
    }
