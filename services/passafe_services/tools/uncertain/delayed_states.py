"""States on their way to the filter, and the set of states in which its next input takes effect."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.numerics.workspace import Array, BlockLayout
from passafe.state_set import ROUNDING, ErrorGrowth
from passafe_services.tools.uncertain.trials import DelayedLink


class DelayedStates:
    """Measured states, which of them are known when, and the roll from there through the inputs that were sent.

    As the filter does (``plant_contract.state_estimate``), each rollout keeps the box of states that agree with all
    readings that it knows: grown through the inputs in force, cut by each reading.
    """

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
        self._applied: list[Array] = []
        self._guarded = [np.zeros(count, dtype=np.intp)]
        self._error = np.array(growth.at_measurement)[:, None]
        self._at = np.zeros(count, dtype=np.intp)
        self._box: Array | None = None
        self._space = BatchWorkspace(BlockLayout.of({"pair": 2 * n, "u": system.m, "after": 2 * n}), count)
        self._step = self._space.bind(growth.period, ["pair", "u"], ["after"])

    def measure(self, x: Array) -> None:
        """Take what was measured at the next plant time, shape (n, count)."""
        self._measured.append(x)

    def send(self, u: Array, applied: Array) -> None:
        """Take the inputs sent for the next plant time, and what a guard made of them, each of shape (m, count)."""
        self._sent.append(u)
        self._applied.append(applied)
        self._guarded.append(self._guarded[-1] + (u != applied).any(axis=0))

    def predicted(self) -> tuple[Array, Array]:
        """Return states and their errors at the next plant time without an input, each of shape (n, count)."""
        now, n = len(self._sent), self._n
        newest = self._newest[max(now - self._ahead, 0)]
        box = self._box = self._read(newest)
        pair = np.zeros_like(box)
        for k in range(int(newest.min()), now + 1):
            known = newest == k
            pair[:, known] = box[:, known]
            if k < now:
                pair = self._rolled(pair, self._sent[k])
        return pair[:n], pair[n:]

    def _read(self, newest: NDArray[np.intp]) -> Array:
        """Return the box of every rollout at its newest state, which the reading of that has cut."""
        at, self._at = self._at, newest
        read = np.array([self._measured[k][:, i] for i, k in enumerate(newest.tolist())]).T
        read = np.concatenate([read, np.broadcast_to(self._error, read.shape)])
        if self._box is None:
            return read
        pair = self._box
        for k in range(int(at.min()), int(newest.max())):
            passed = (at <= k) & (k < newest)
            # A state tells the input in force; what was sent tells those of states that were lost.
            u = np.where(k == at, self._applied[k], self._sent[k])
            pair = np.where(passed, self._rolled(pair, u), pair)
        guarded = np.array([self._guarded[k][i] for i, k in enumerate(newest.tolist())])
        guarded -= np.array([self._guarded[k][i] for i, k in enumerate(at.tolist())])
        is_unknown = (newest - at > 1) & (guarded > 0)
        return np.where(newest == at, self._box, np.where(is_unknown, read, self._cut(pair, read)))

    def _cut(self, allowed: Array, read: Array) -> Array:
        """Return the boxes of the states that are in both; the one that was read where there are none."""
        n = self._n
        low = np.maximum(allowed[:n] - allowed[n:], read[:n] - read[n:])
        high = np.minimum(allowed[:n] + allowed[n:], read[:n] + read[n:])
        room = allowed[n:] + read[n:] + ROUNDING * (1 + np.abs(allowed[:n]))
        is_violated = (np.abs(read[:n] - allowed[:n]) > room).any(axis=0)
        cut = np.concatenate([(low + high) / 2, np.maximum((high - low) / 2, 0.0)])
        return np.where(is_violated, read, cut)

    def _rolled(self, pair: Array, u: Array) -> Array:
        """Return state and error one period later, shape (2n, count)."""
        used = self._space.used
        self._space.part("pair")[:, :used], self._space.part("u")[:, :used] = pair, u
        self._step()
        return self._space.part("after")[:, :used].copy()


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
