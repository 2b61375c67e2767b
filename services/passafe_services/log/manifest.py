"""Manifest of the messages between two checkpoints: each in short, so that a change is found at its place.

A message's digest is the SHA-256 of sequence (4 bytes), log time (8), publish time (8), length of the key expression
(2), the key expression and the data, integers little-endian. The manifest has, for each message in order, its channel
(2 bytes), sequence (4), log time (8) and the first ``TAG_BYTES`` of its digest, as columns: sequences as differences
within a channel, times as differences from one message to the next, both as signed 8-byte integers of which all first
bytes come first, then all second ones; compressed by zlib, in base 64.
"""

import zlib
from base64 import b64decode, b64encode
from hashlib import sha256
from struct import Struct
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

TAG_BYTES: Final = 6
"""Enough to tell messages of one interval apart; that none was changed is what the digest of all of them shows."""

_TIMES: Final = Struct("<IQQ")
_LENGTH: Final = Struct("<H")
_LEVEL: Final = 1
_Integers: TypeAlias = NDArray[np.int64]


class Entry(NamedTuple):
    """One message in short.

    Attributes:
        channel: Number of its channel.
        sequence: Its sequence number.
        wall_ns: Its log time, ns.
        tag: First bytes of its digest.
    """

    channel: int
    sequence: int
    wall_ns: int
    tag: bytes


def key_prefix(key: str) -> bytes:
    """Return what stands for the key expression in the digests of its messages."""
    data = key.encode()
    return _LENGTH.pack(len(data)) + data


def message_digest(prefix: bytes, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> bytes:
    """Return the digest of a message.

    Args:
        prefix: ``key_prefix`` of its key expression.
        sequence: Its sequence number in the log.
        log_ns: Its log time, ns.
        publish_ns: Its publish time, ns.
        data: Its wire bytes.
    """
    return sha256(_TIMES.pack(sequence, log_ns, publish_ns) + prefix + data).digest()


class Manifest:
    """Messages since the last checkpoint.

    Attributes:
        newest_ns: Log time of the newest message, ns.
        channels: Channel of every message, in order.
    """

    def __init__(self) -> None:
        self.newest_ns = 0
        self.channels: list[int] = []
        self._sequences: list[int] = []
        self._times: list[int] = []
        self._tags = bytearray()
        self._digest = sha256()

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.channels)

    def add(self, channel: int, sequence: int, wall_ns: int, digest: bytes) -> None:
        """Add a message."""
        self.channels.append(channel)
        self._sequences.append(sequence)
        self._times.append(wall_ns)
        self._tags += digest[:TAG_BYTES]
        self._digest.update(digest)
        self.newest_ns = max(self.newest_ns, wall_ns)

    @property
    def entries(self) -> list[Entry]:
        """The messages, in order."""
        tags = (bytes(self._tags[at : at + TAG_BYTES]) for at in range(0, len(self._tags), TAG_BYTES))
        return [Entry(*each) for each in zip(self.channels, self._sequences, self._times, tags, strict=True)]

    @property
    def digest(self) -> str:
        """SHA-256 of the digests of all messages in order, in hexadecimal digits."""
        return self._digest.hexdigest()

    @property
    def text(self) -> str:
        """The manifest as it is in a checkpoint."""
        if not self.channels:
            return ""
        number = np.array(self.channels, dtype="<u2")
        steps = _steps_of_channels(number, np.array(self._sequences, dtype=np.int64))
        moments = _steps(np.array(self._times, dtype=np.uint64).astype(np.int64))
        columns = number.tobytes() + _planes(steps) + _planes(moments) + bytes(self._tags)
        return b64encode(zlib.compress(columns, _LEVEL)).decode()


def entries_of(text: str, count: int) -> list[Entry]:
    """Return the messages of a manifest.

    Args:
        text: The manifest as it is in a checkpoint.
        count: Number of its messages.

    Raises:
        ValueError: It is none of so many messages.
    """
    if not count:
        return []
    size_bytes = count * (2 + 8 + 8 + TAG_BYTES)
    try:
        columns = zlib.decompressobj().decompress(b64decode(text, validate=True), size_bytes + 1)
    except zlib.error as error:
        raise ValueError(str(error)) from error
    if len(columns) != size_bytes:
        raise ValueError(f"manifest: got {len(columns)} bytes, allowed {size_bytes}")
    number = np.frombuffer(columns, dtype="<u2", count=count)
    sequences = _from_steps(number, _from_planes(columns[2 * count : 10 * count]))
    times = np.cumsum(_from_planes(columns[10 * count : 18 * count])).astype(np.uint64)
    tags = [columns[at : at + TAG_BYTES] for at in range(18 * count, len(columns), TAG_BYTES)]
    return [Entry(*each) for each in zip(number.tolist(), sequences.tolist(), times.tolist(), tags, strict=True)]


def _steps_of_channels(channels: NDArray[Any], sequences: _Integers) -> _Integers:
    """Return the difference of every sequence number from the one before on its channel; the first as it is."""
    steps = sequences.copy()
    for channel in np.unique(channels):
        places = channels == channel
        steps[places] = _steps(sequences[places])
    return steps


def _steps(values: _Integers) -> _Integers:
    """Return the difference of each value from the one before; the first as it is."""
    return values - np.concatenate(([0], values[:-1]))


def _from_steps(channels: NDArray[Any], steps: _Integers) -> _Integers:
    sequences = steps.copy()
    for channel in np.unique(channels):
        places = channels == channel
        sequences[places] = np.cumsum(steps[places])
    return sequences


def _planes(values: _Integers) -> bytes:
    """Return integers with all first bytes first: small ones compress well."""
    return values.astype("<i8").view(np.uint8).reshape(-1, 8).T.tobytes()


def _from_planes(data: bytes) -> _Integers:
    planes = np.frombuffer(data, dtype=np.uint8).reshape(8, -1)
    return np.ascontiguousarray(planes.T).view("<i8").reshape(-1).astype(np.int64)
