"""Messages that ticks consumed, and those that were sent: which was the newest at each tick."""

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.filter_claims import IntArray

MOST_KEPT: Final = 1 << 17
"""Messages of a session that are kept for ticks that consume them: two minutes at 1 kHz."""

Found = tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]


class ConsumedMessages(NamedTuple):
    """Messages of one topic that the ticks of a block consumed, in their order.

    Attributes:
        row: Row of the tick in the block, shape (K,).
        sequence: Their numbers, shape (K,).
        received_ns: When each was received, ns, shape (K,).
        epoch: Their sessions, shape (K,).
        ticks: Number of ticks of the block.
    """

    row: NDArray[np.intp]
    sequence: IntArray
    received_ns: IntArray
    epoch: NDArray[np.uint64]
    ticks: int

    @classmethod
    def of(cls, block: MessageBlock, topic: str) -> Self:
        """Return those of a block of ticks."""
        wanted = block.texts("consumed.topic").are(topic)
        numbers = block.ragged("consumed.sequence")
        return cls(
            row=numbers.row_numbers[wanted],
            sequence=numbers.values[wanted].astype(np.int64),
            received_ns=block.ragged("consumed.received_ns").values[wanted],
            epoch=block.ragged("consumed.epoch").values[wanted],
            ticks=len(block),
        )

    def twice(self, count: int) -> NDArray[np.bool_]:
        """Return which of ``count`` ticks consumed a message that another or the same did, shape (N,)."""
        found = np.zeros(count, dtype=np.bool_)
        order = np.lexsort((self.sequence, self.epoch))
        same = (np.diff(self.sequence[order]) == 0) & (np.diff(self.epoch[order].astype(np.int64)) == 0)
        found[self.row[order[1:][same]]] = True
        return found


class Newest:
    """The newest message of one topic that each session of the filter had consumed.

    Attributes:
        epochs: Sessions of the senders, with the first tick that consumed a message of each.
    """

    def __init__(self) -> None:
        self.epochs: dict[int, int] = {}
        self._last: dict[int, tuple[int, int, int]] = {}
        self._several: set[int] = set()

    def follow(
        self, session: int, consumed: ConsumedMessages, ticks: IntArray
    ) -> tuple[int, IntArray, IntArray] | None:
        """Return the newest message at each tick of a block; ``None`` if the filter received from several sessions.

        Args:
            session: Session of the filter.
            consumed: What the ticks consumed.
            ticks: Their numbers.

        Returns:
            The sender's session; by tick the number of its newest message, −1 before the first, and when that was
            received, ns.
        """
        for epoch in np.unique(consumed.epoch).tolist():
            self.epochs.setdefault(epoch, int(ticks[int(consumed.row[consumed.epoch == epoch][0])]))
        epoch, before, received = self._last.get(session, (0, -1, 0))
        found = {*np.unique(consumed.epoch).tolist(), *({epoch} if before >= 0 else ())}
        if len(found) > 1 or session in self._several:
            self._several.add(session)
            return None
        epoch = next(iter(found), 0)
        numbers = np.concatenate(([before], consumed.sequence))
        newest = np.maximum.accumulate(numbers)
        at = np.concatenate(([received], consumed.received_ns))
        first = np.maximum.accumulate(np.where(numbers == newest, np.arange(numbers.size), 0))
        counts = np.bincount(consumed.row, minlength=consumed.ticks)
        place = np.cumsum(counts)
        self._last[session] = epoch, int(newest[-1]), int(at[first[-1]])
        return epoch, newest[place], at[first[place]]


class LoggedMessages:
    """Messages of one topic that were sent, the newest of each session, by number.

    Args:
        numbers: Columns of numbers that are kept.
        vectors: Columns of vectors that are kept, and their lengths.
    """

    def __init__(self, numbers: Sequence[str], vectors: Mapping[str, int] | None = None) -> None:
        self._numbers, self._vectors = numbers, vectors or {}
        self._of: dict[int, tuple[IntArray, dict[str, NDArray[Any]]]] = {}

    @property
    def sessions(self) -> int:
        """Number of sessions that sent any."""
        return len(self._of)

    def knows(self, epoch: int) -> bool:
        """Return whether a session sent any."""
        return epoch in self._of

    def add(self, block: MessageBlock) -> None:
        """Take the next messages of a session."""
        sequence = block.sequence.astype(np.int64)
        columns: dict[str, NDArray[Any]] = {path: block.numbers(path) for path in self._numbers}
        columns |= {path: block.ragged(path).matrix(length) for path, length in self._vectors.items()}
        if block.epoch in self._of:
            numbers, before = self._of[block.epoch]
            sequence = np.concatenate((numbers, sequence))
            columns = {path: np.concatenate((before[path], column)) for path, column in columns.items()}
        self._of[block.epoch] = sequence[-MOST_KEPT:], {path: each[-MOST_KEPT:] for path, each in columns.items()}

    def find(self, epoch: int, wanted: IntArray) -> Found:
        """Return the columns of messages by their numbers, and which of them are known."""
        if epoch not in self._of:
            none: dict[str, NDArray[Any]] = {path: np.zeros(wanted.size, dtype=np.int64) for path in self._numbers}
            none |= {path: np.zeros((wanted.size, length)) for path, length in self._vectors.items()}
            return none, np.zeros(wanted.size, dtype=np.bool_)
        sequence, columns = self._of[epoch]
        place = np.minimum(np.searchsorted(sequence, wanted), sequence.size - 1)
        return {path: column[place] for path, column in columns.items()}, sequence[place] == wanted

    def follow(self, epoch: int, wanted: IntArray, path: str, longest: int) -> NDArray[np.bool_]:
        """Return of which messages it is certain that a number grew by no more than possible since any before.

        Args:
            epoch: Session that sent them.
            wanted: Their numbers.
            path: Column of the number.
            longest: The most by which it grows from one message to the next.
        """
        if epoch not in self._of:
            return np.zeros(wanted.size, dtype=np.bool_)
        sequence, columns = self._of[epoch]
        beyond = columns[path] - longest * sequence
        follows: NDArray[np.bool_] = beyond <= np.minimum.accumulate(beyond)
        return follows[np.minimum(np.searchsorted(sequence, wanted), sequence.size - 1)]
