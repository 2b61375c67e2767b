"""Verifies a log by its checkpoints: is it as the recorder wrote it, and if not, what was changed?"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from mcap.records import Channel, Header, Message, Metadata
from pydantic import BaseModel, ConfigDict

from passafe_services.keys.key_files import read_certificate
from passafe_services.log.chain_audit import ChainAudit
from passafe_services.log.checkpoint import (
    CHECKPOINT_RECORD,
    SIGNER_RECORD,
    Checkpoint,
    record_digest,
    signature_of,
)
from passafe_services.log.interval_diff import ChangedMessage, changed_messages
from passafe_services.log.log_reader import LogReader
from passafe_services.log.manifest import Manifest, entries_of, key_prefix, message_digest
from passafe_services.log.record_scan import Damage
from passafe_services.log.rewritten_log import changes_of_rewritten
from passafe_services.log.trust import LogSigner

MOST_NAMED: Final = 1000
"""Changed messages that are named; the others are counted."""
_MOST_IN_ORDER: Final = 100
"""Changed messages beyond which the log is compared without regard to order."""
_MOST_HELD: Final = 1 << 20
"""Messages without a checkpoint that are held to be compared."""


class NamedMessage(BaseModel):
    """Message that is not as the recorder wrote it.

    Attributes:
        change: ``changed``, ``left out``, ``added`` or ``moved``.
        key: Key expression under which it was published.
        sequence: Its sequence number.
        wall_ns: Its log time, Unix time, ns.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    change: str
    key: str
    sequence: int
    wall_ns: int


class Verification(BaseModel):
    """Result of a verification.

    Attributes:
        holds: Whether all of the log is signed, and nothing speaks against it.
        signer: Holder of the certificate that signed it; empty if it is not signed.
        fingerprint: SHA-256 fingerprint of the certificate.
        is_pinned: Whether the reader named the authority or the certificate; otherwise the log names its own.
        checkpoints: Checkpoints with a valid signature; of a log that is not signed, intact ones.
        messages: Messages in the log.
        attested: Messages that such a checkpoint attests, and that are as it says.
        unattested: Messages after the last checkpoint, as at the end of a torn log.
        unattested_from_ns: Log time of the first of these, ns; ``None`` without one.
        found: Messages that are not as the recorder wrote them, at most ``MOST_NAMED``.
        found_in_all: Number of all of these.
        doubts: What else speaks against the log, in words.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    holds: bool
    signer: str
    fingerprint: str
    is_pinned: bool
    checkpoints: int
    messages: int
    attested: int
    unattested: int
    unattested_from_ns: int | None
    found: list[NamedMessage]
    found_in_all: int
    doubts: list[str]


def verify(path: Path, pinned: Path | None = None) -> Verification:
    """Verify a log.

    Args:
        path: Its first file, or a folder that holds one recording.
        pinned: Certificate of the authority that is trusted, or of the recorder itself.

    Raises:
        LogReadError: A file is missing, empty or no MCAP file.
        KeysError: ``pinned`` is no certificate.
    """
    if pinned is not None:
        read_certificate(pinned)  # also where the log is not signed: a wrong name must not look like a wrong log
    reader, check = LogReader(path), _Check(pinned)
    for item in reader.items():
        match item:
            case Damage():
                check.doubts.append(f"damage: {item}")
            case Header():
                check.begin_file()
            case Channel():
                check.channels.setdefault(item.id, item.topic)
            case Message():
                check.message(item)
            case Metadata():
                check.metadata(item.name, item.metadata)
            case _:
                pass
    if check.is_rewritten:
        check.compare_unordered(reader)
    return check.result()


class _Check:
    """State of a verification."""

    def __init__(self, pinned: Path | None) -> None:
        self.channels: dict[int, str] = {}
        self.doubts: list[str] = []
        self._pinned = pinned
        self._audit = ChainAudit()
        self._signer: LogSigner | None = None
        self._records: dict[str, str] = {}
        self._altered: set[str] = set()
        self._manifest = Manifest()
        self._changes: list[ChangedMessage] = []
        self._messages = self._attested = self._checkpoints = self._found = 0
        self._unsigned: list[int] = []
        self._valid: list[int] = []

    def begin_file(self) -> None:
        """Begin another file, with metadata of its own."""
        self._records = {}

    def message(self, record: Message) -> None:
        """Note a message."""
        self._messages += 1
        prefix = key_prefix(self.channels.get(record.channel_id, ""))
        digest = message_digest(prefix, record.sequence, record.log_time, record.publish_time, record.data)
        if len(self._manifest) < _MOST_HELD:
            self._manifest.add(record.channel_id, record.sequence, record.log_time, digest)

    def metadata(self, name: str, record: Mapping[str, str]) -> None:
        """Note a metadata record; verify what a checkpoint attests."""
        if name != CHECKPOINT_RECORD:
            self._records[name] = record_digest(record)
            if name == SIGNER_RECORD and self._signer is None:
                self._signer = LogSigner.of(record, self._pinned)
            return
        manifest, self._manifest = self._manifest, Manifest()
        checkpoint = self._audit.take(record)
        if checkpoint is None:
            return
        self._altered |= {key for key, digest in checkpoint.metadata.items() if self._records.get(key) != digest}
        if not self._is_signed(checkpoint, record):
            self._unsigned.append(checkpoint.number)
            return
        self._checkpoints += 1
        self._valid.append(checkpoint.number)
        self._compare(checkpoint, manifest)

    @property
    def is_rewritten(self) -> bool:
        """True if messages and checkpoints are hardly in the order of the recorder."""
        ended = self._audit.last is not None and self._audit.last.final
        return self._found > _MOST_IN_ORDER or (ended and len(self._manifest) > 0)

    def compare_unordered(self, reader: LogReader) -> None:
        """Compare messages and checkpoints without regard to their order."""
        changes = changes_of_rewritten(reader, self._valid)
        if changes is None or len(changes) >= self._found + len(self._manifest):
            return
        self.doubts.append("messages or checkpoints are in another order than the recorder's: it was written anew")
        self._attested = self._messages - sum(1 for each in changes if each.change != "left out")
        self._found, self._changes, self._manifest = len(changes), changes[:MOST_NAMED], Manifest()

    def _is_signed(self, checkpoint: Checkpoint, record: Mapping[str, str]) -> bool:
        signer = self._signer
        if signer is None:
            return not signature_of(record)
        valid = signer.was_valid(checkpoint.wall_ns) or not checkpoint.wall_ns
        return valid and signer.has_signed(record["body"], signature_of(record))

    def _compare(self, checkpoint: Checkpoint, manifest: Manifest) -> None:
        """Compare the messages since the last checkpoint with what this one attests."""
        if manifest.digest == checkpoint.digest and len(manifest) == checkpoint.messages:
            self._attested += checkpoint.messages
            return
        try:
            attested = entries_of(checkpoint.manifest, checkpoint.messages)
        except ValueError as error:
            self.doubts.append(f"checkpoint {checkpoint.number}: {error}")
            return
        numbers = {key: number for number, key in checkpoint.channels.items()}
        found = [
            entry._replace(channel=numbers.get(self.channels.get(entry.channel, ""), -1)) for entry in manifest.entries
        ]
        changes = changed_messages(attested, found, checkpoint.channels)
        if not changes:
            self.doubts.append(f"checkpoint {checkpoint.number}: its messages are not as they were written")
        self._attested += max(0, len(attested) - sum(1 for each in changes if each.change != "added"))
        self._found += len(changes)
        self._changes += changes[: MOST_NAMED - len(self._changes)]

    def result(self) -> Verification:
        """Return what was found."""
        signer, last = self._signer, self._audit.last
        doubts = [*self._doubts_of_the_signer(), *self._audit.breaks, *self.doubts]
        doubts += [f"metadata record {name} is not as it was written" for name in sorted(self._altered)]
        if self._unsigned and signer is not None:
            doubts.append(f"checkpoints without a valid signature: {_numbers(self._unsigned)}")
        if last is not None and not last.final:
            doubts.append("the end is missing: what came after the last checkpoint may have been cut off")
        unattested = self._manifest.entries
        if unattested:
            doubts.append(f"{len(unattested)} messages after the last checkpoint are not attested")
        return Verification(
            holds=not (doubts or self._found),
            signer="" if signer is None else signer.holder.common_name,
            fingerprint="" if signer is None else signer.fingerprint,
            is_pinned=signer is not None and signer.is_pinned,
            checkpoints=self._checkpoints,
            messages=self._messages,
            attested=self._attested,
            unattested=len(unattested),
            unattested_from_ns=unattested[0].wall_ns if unattested else None,
            found=[NamedMessage(**each._asdict()) for each in self._changes],
            found_in_all=self._found,
            doubts=doubts,
        )

    def _doubts_of_the_signer(self) -> list[str]:
        if self._audit.last is None and not self._audit.breaks:
            return ["it has no checkpoints: it was written before there were any, or by another program"]
        if self._signer is None:
            return ["it is not signed: whoever can write the file can compute its checkpoints anew"]
        return [self._signer.doubt] if self._signer.doubt else []


def _numbers(numbers: list[int]) -> str:
    return f"{len(numbers)}, the first {numbers[0]}"
