"""States on their way to the filter, and the set of states in which its next input takes effect."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.state_set import ErrorGrowth
from passafe.workspace import Array, BlockLayout
from passafe_services.tools.uncertain.trials import DelayedLink


class DelayedStates:
    """Measured states, which of them are known when, and the roll from there through the inputs that were sent."""

    def __init__(
        self, link: DelayedLink, growth: ErrorGrowth, ticks: int, rngs: Sequence[np.random.Generator], dt_s: float
    ) -> None:
        """Draw when each state arrives.

        Args:
            link: The network.
            growth: Follows error and state.
            ticks: How many periods there are.
            rngs: A generator for each rollout.
            dt_s: Period, s.
        """
        count, system = len(rngs), growth.design.system
        self._n = n = system.n
        self._ahead = round(link.input_delay_s / dt_s)
        self._newest = _newest(link, ticks, rngs, dt_s)
        self._measured: list[Array] = []
        self._sent: list[Array] = []
        self._error = np.array(growth.at_measurement)[:, None]
        self._space = BatchWorkspace(BlockLayout.of({"pair": 2 * n, "u": system.m, "after": 2 * n}), count)
        self._step = self._space.bind(growth.period, ["pair", "u"], ["after"])

    def measure(self, x: Array) -> None:
        """Take what was measured at the next plant time, shape (n, count)."""
        self._measured.append(x)

    def send(self, u: Array) -> None:
        """Take the inputs sent for the next plant time, shape (m, count)."""
        self._sent.append(u)

    def predicted(self) -> tuple[Array, Array]:
        """Return states and their errors at the next plant time without an input, each of shape (n, count)."""
        now, n, used = len(self._sent), self._n, self._space.used
        newest = self._newest[max(now - self._ahead, 0)]
        pair = np.zeros((2 * n, used))
        for k in range(int(newest.min()), now + 1):
            known = newest == k
            pair[:n, known] = self._measured[k][:, known]
            pair[n:, known] = self._error
            if k < now:
                self._space.part("pair")[:, :used], self._space.part("u")[:, :used] = pair, self._sent[k]
                self._step()
                pair = self._space.part("after")[:, :used].copy()
        return pair[:n], pair[n:]


def _newest(link: DelayedLink, ticks: int, rngs: Sequence[np.random.Generator], dt_s: float) -> NDArray[np.intp]:
    """Return the newest state known at each plant time, shape (ticks + 1, count); the first is known from the start."""
    newest = np.zeros((ticks + 1, len(rngs)), dtype=np.intp)
    states = np.arange(ticks + 1)
    for i, rng in enumerate(rngs):
        delay_s = rng.uniform(link.state_low_s, link.state_high_s, ticks + 1)
        arrives = states + np.ceil(delay_s / dt_s - 1e-9).astype(np.intp)
        arrives[rng.uniform(size=ticks + 1) < link.state_loss] = ticks + 1
        in_time = arrives <= ticks
        np.maximum.at(newest[:, i], arrives[in_time], states[in_time])
    return np.maximum.accumulate(newest, axis=0)
