"""Messages of one session of a publisher as a table, in order: what a pass over a log hands out."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.topics import Topic

from passafe_services.log.column import Column, Ragged, Texts


@dataclass(frozen=True, eq=False)
class MessageBlock:
    """Messages of one session of a publisher on one topic, in order of sequence, each once.

    Gaps are where ``sequence`` skips a number. The blocks of a session follow one another in order; those of several
    sessions may take turns.

    Attributes:
        topic: The topic.
        source: The publisher.
        epoch: Its session.
        session: Number of the session on this topic, in the order in which the log met them.
        columns: Columns by path, see ``numbers``, ``texts`` and ``ragged``.
    """

    topic: Topic
    source: str
    epoch: int
    session: int
    columns: dict[str, Column] = field(repr=False)

    def __len__(self) -> int:
        return len(self.sequence)

    @property
    def sequence(self) -> NDArray[np.uint64]:
        """Sequence numbers, increasing, shape (N,)."""
        return self.numbers("header.sequence")

    def numbers(self, path: str) -> NDArray[Any]:
        """Return a column of numbers, one a message, shape (N,)."""
        found: NDArray[Any] = self._column(path, np.ndarray)
        return found

    def ragged(self, path: str) -> Ragged:
        """Return a vector or a field within a list: a varying number of values for each message."""
        found: Ragged = self._column(path, Ragged)
        return found

    def matrix(self, path: str, width: int) -> NDArray[Any]:
        """Return a vector of known length as columns, shape (width, N); NaN where a message has another length."""
        return self.ragged(path).matrix(width).T

    def texts(self, path: str) -> Texts:
        """Return a column of texts."""
        found: Texts = self._column(path, Texts)
        return found

    def objects(self, path: str) -> Sequence[Any]:
        """Return the column ``record``, (header, body) of each message, or ``wire``, its bytes."""
        found: list[Any] = self.numbers(path).tolist()
        return found

    def _column(self, path: str, kind: type[Any]) -> Any:  # noqa: ANN401 - of the kind asked for
        column = self.columns[path]
        if not isinstance(column, kind):
            raise TypeError(f"{self.topic.name}.{path}: got {type(column).__name__}, allowed {kind.__name__}")
        return column
