"""Keep every sample of a few stretches of a run: those with extremes and events, and all of a short run."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray


class DetailBlock(NamedTuple):
    """Every sample of a stretch.

    Attributes:
        t_ns: Plant times, ns, shape (N,).
        values: Signals, shape (columns, N).
    """

    t_ns: IntArray
    values: FloatArray


class DetailBlocks:
    """The stretches of a run that are kept sample by sample, at most ``most`` samples of them.

    When there are more, one that holds no extreme and was not asked for goes first, the oldest of those.

    Args:
        lowest: Numbers of the columns whose lowest value ever is shown sample by sample.
        highest: The same for the highest.
        most: Number of samples.
    """

    def __init__(self, *, lowest: Sequence[int], highest: Sequence[int], most: int) -> None:
        self._best: dict[tuple[int, int], tuple[float, int]] = {}
        self._lowest, self._highest = list(lowest), list(highest)
        self._keys = [(column, 1) for column in lowest] + [(column, -1) for column in highest]
        self._most = most
        self._blocks: dict[int, DetailBlock] = {}
        self._asked: set[int] = set()
        self._made = self._samples = 0
        self.complete = True

    def add(self, block: DetailBlock, *, asked: bool = False) -> None:
        """Add the next stretch.

        Args:
            block: Its samples.
            asked: Whether something happened in it, so that it is kept while there is room.
        """
        number, self._made = self._made, self._made + 1
        self._blocks[number] = block
        if asked:
            self._asked.add(number)
        for (column, sign), value in zip(self._keys, self._worst(block.values), strict=True):
            best = self._best.get((column, sign))
            if value == value and (best is None or value < best[0]):  # noqa: PLR0124 - not NaN
                self._best[column, sign] = (value, number)
        self._samples += block.t_ns.size
        while self._samples > self._most and len(self._blocks) > 1:
            self._drop_one()

    @property
    def kept(self) -> list[DetailBlock]:
        """The stretches, in order of time."""
        return sorted((block for block in self._blocks.values()), key=lambda block: int(block.t_ns[0]))

    def _worst(self, values: FloatArray) -> list[float]:
        """Return the worst value of each key: the lower, the worse."""
        lowest = np.fmin.reduce(values[self._lowest], axis=1)
        highest = np.fmax.reduce(values[self._highest], axis=1)
        return [*lowest.tolist(), *(-highest).tolist()]

    def _drop_one(self) -> None:
        self.complete = False
        extremes = {number for _, number in self._best.values()}
        plain = (number for number in self._blocks if number not in extremes and number not in self._asked)
        asked = (number for number in self._blocks if number not in extremes)
        number = next(plain, None)
        if number is None:
            number = next(asked, next(iter(self._blocks)))
        self._samples -= self._blocks.pop(number).t_ns.size
        self._asked.discard(number)
