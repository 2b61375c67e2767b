"""Find the stretches of a run in which something was so, such as a barrier below 0."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray


class Span(NamedTuple):
    """A stretch of plant time.

    Attributes:
        start_ns: Its first sample, ns.
        end_ns: Its last sample, ns.
        worst: Lowest value in it.
        worst_ns: When that was, ns.
    """

    start_ns: int
    end_ns: int
    worst: float
    worst_ns: int


class SpanRecorder:
    """The stretches in which a condition holds: the first and the worst ones, and how many there were.

    Args:
        most: Number of stretches kept.
    """

    def __init__(self, *, most: int = 50) -> None:
        self.count = 0
        self._most = most
        self._spans: list[Span] = []
        self._open: Span | None = None

    def add(self, t_ns: IntArray, condition: NDArray[np.bool_], values: FloatArray) -> None:
        """Add samples in order of time: whether the condition holds at each, and the value that grades it."""
        if not condition.any():
            self._close()
            return
        edges = np.flatnonzero(np.diff(condition, prepend=False, append=False))
        for start, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            worst = start + int(np.argmin(values[start:end]))
            found = Span(int(t_ns[start]), int(t_ns[end - 1]), float(values[worst]), int(t_ns[worst]))
            if start or self._open is None:
                self._close()
                self._open = found
                self.count += 1
            else:
                graver = min(self._open, found, key=lambda span: span.worst)
                self._open = Span(self._open.start_ns, found.end_ns, graver.worst, graver.worst_ns)
        if not condition[-1]:
            self._close()

    @property
    def spans(self) -> list[Span]:
        """The stretches kept, in order of time."""
        held = self._spans if self._open is None else [*self._spans, self._open]
        return sorted(held)

    def _close(self) -> None:
        if self._open is not None:
            self._keep(self._open)
            self._open = None

    def _keep(self, span: Span) -> None:
        self._spans.append(span)
        if len(self._spans) > self._most:
            later = self._spans[1:]  # the first one says when it began
            later.remove(max(later, key=lambda one: one.worst))
            self._spans = [self._spans[0], *later]
