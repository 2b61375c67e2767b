"""StateMeasurement of a simulated robot's state: noise drawn by seed, and quantisation."""

from functools import lru_cache
from typing import Final

import numpy as np
from passafe_protocol.messages import Vector

BLOCK: Final = 1024
"""Periods whose noise is drawn at once: one draw at a time would cost 20 µs."""


class StateMeasurement:
    """Reads a true state with errors that depend on the number of the period alone."""

    def __init__(self, *, bound: Vector, seed: int, steps: Vector) -> None:
        """Keep the sizes of the errors.

        Args:
            bound: Largest magnitude of the noise of each state, n numbers.
            seed: Of the draws.
            steps: Quantisation steps of each state, n numbers; 0 for none.
        """
        self._steps = steps
        self._has_noise, self._has_steps = any(bound), any(steps)

        @lru_cache(maxsize=2)
        def drawn(block: int) -> list[list[float]]:
            noise: list[list[float]] = (
                np.random.default_rng((seed, block)).uniform(-1.0, 1.0, (BLOCK, len(bound))) * bound
            ).tolist()
            return noise

        self._drawn = drawn

    def of(self, x: Vector, period: int) -> Vector:
        """Return the state as it is read.

        Args:
            x: True state, n numbers.
            period: Number of the period since the start.
        """
        if self._has_noise:
            block, place = divmod(period, BLOCK)
            x = tuple(value + error for value, error in zip(x, self._drawn(block)[place], strict=True))
        if self._has_steps:
            x = tuple(round(value / step) * step if step else value for value, step in zip(x, self._steps, strict=True))
        return x
