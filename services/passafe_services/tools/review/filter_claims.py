"""Inputs and decisions of the filter as arrays, from a log or from a loop without one."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import UNSEQUENCED, FilterStatus, FilterTick, PlantInput

from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.plant_evaluator import FloatArray

_SEQUENCE_START: Final = "input_sequence_start_ns"

IntArray = NDArray[np.int64]

NS_PER_S: Final = 1e9

ANSWERED: Final = (FilterStatus.PASSED, FilterStatus.MODIFIED, FilterStatus.RELAXED)
"""Statuses that claim a certified solution; every other one is a defined fallback."""


@dataclass(frozen=True, kw_only=True)
class SentInputs:
    """Inputs that the filter sent, in order.

    Attributes:
        u: The inputs, shape (m, K); infinite where a message held another number of axes.
        at_ns: Plant time at which each takes effect, ns, shape (K,).
        sequence_start_ns: Start of each one's input sequence, ns, shape (K,).
    """

    u: FloatArray
    at_ns: IntArray
    sequence_start_ns: IntArray

    @classmethod
    def of(cls, sent: Iterable[PlantInput], m: int) -> Self:
        """Extract them from the messages to a plant with m axes."""
        inputs, strange = list(sent), (inf,) * m
        vectors = [one.u if len(one.u) == m else strange for one in inputs]
        return cls(
            u=np.array(vectors, dtype=np.float64).reshape(len(inputs), m).T,
            at_ns=np.array([one.effective_plant_ns for one in inputs], dtype=np.int64),
            sequence_start_ns=np.array([one.input_sequence_start_ns for one in inputs], dtype=np.int64),
        )

    @classmethod
    def in_block(cls, block: MessageBlock, m: int) -> Self:
        """Extract them from a block of messages to a plant with m axes."""
        vectors = block.ragged("u")
        u = vectors.matrix(m).T.copy()
        u[:, vectors.counts != m] = inf
        return cls(u=u, at_ns=block.numbers("effective_plant_ns"), sequence_start_ns=block.numbers(_SEQUENCE_START))

    def last(self) -> Self:
        """Return the last one by itself."""
        return replace(self, u=self.u[:, -1:], at_ns=self.at_ns[-1:], sequence_start_ns=self.sequence_start_ns[-1:])

    def followed_by(self, other: Self) -> Self:
        """Return these inputs and others behind them."""
        return replace(
            self,
            u=np.concatenate((self.u, other.u), axis=1),
            at_ns=np.concatenate((self.at_ns, other.at_ns)),
            sequence_start_ns=np.concatenate((self.sequence_start_ns, other.sequence_start_ns)),
        )

    def follows(self, period_s: float) -> NDArray[np.bool_]:
        """Return which inputs follow the one before in their input sequence, shape (K − 1,).

        Those were decided with that one in force, so that the limits of the rates hold between the two.

        Args:
            period_s: The filter's period, s.
        """
        starts = self.sequence_start_ns
        in_turn = np.abs(np.diff(self.at_ns) - period_s * NS_PER_S) <= 1.0  # times are whole nanoseconds
        same: NDArray[np.bool_] = (starts[1:] == starts[:-1]) & (starts[1:] != UNSEQUENCED)
        return same & in_turn


@dataclass(frozen=True, kw_only=True)
class Decisions:
    """Ticks of the filter, in order.

    Attributes:
        status: Status, shape (K,).
        residual: Largest of the certificate's residuals and gap; +∞ if the certificate was not accepted; shape (K,).
        at_ns: Plant time of the decision, ns, shape (K,).
        slack_w: Slack of the passivity row, W, shape (K,).
        command_age_ns: Age of the newest command, ns, −1 without one; shape (K,).
        state_age_ns: Age of the newest state, ns, −1 without one; shape (K,).
    """

    status: IntArray
    residual: FloatArray
    at_ns: IntArray
    slack_w: FloatArray
    command_age_ns: IntArray
    state_age_ns: IntArray

    @classmethod
    def in_block(cls, block: MessageBlock) -> Self:
        """Extract them from a block of messages."""
        parts = [block.numbers(f"certificate.{part}") for part in ("primal_residual", "dual_residual", "gap")]
        return cls(
            status=block.numbers("status"),
            residual=np.where(block.numbers("certificate.accepted"), np.max(parts, axis=0), inf),
            at_ns=block.numbers("effective_plant_ns"),
            slack_w=block.numbers("slack"),
            command_age_ns=block.numbers("command_age_ns"),
            state_age_ns=block.numbers("state_age_ns"),
        )

    @classmethod
    def of(cls, ticks: Sequence[FilterTick]) -> Self:
        """Extract them from the messages."""
        return cls(
            status=np.array([tick.status for tick in ticks], dtype=np.int64),
            residual=np.array([_residual(tick) for tick in ticks], dtype=np.float64),
            at_ns=np.array([tick.effective_plant_ns for tick in ticks], dtype=np.int64),
            slack_w=np.array([tick.slack for tick in ticks], dtype=np.float64),
            command_age_ns=np.array([tick.command_age_ns for tick in ticks], dtype=np.int64),
            state_age_ns=np.array([tick.state_age_ns for tick in ticks], dtype=np.int64),
        )

    @property
    def counts(self) -> dict[str, int]:
        """Number of ticks of each status, in the order of first occurrence."""
        seen, first, counts = np.unique(self.status, return_index=True, return_counts=True)
        return {FilterStatus(int(seen[k])).name: int(counts[k]) for k in np.argsort(first)}

    def uncertified(self, limit: float) -> NDArray[np.bool_]:
        """Return which ticks claim a solution without a certificate within ``limit``, shape (K,)."""
        kept = self.residual <= limit  # a NaN is not
        return np.isin(self.status, ANSWERED) & ~kept


def _residual(tick: FilterTick) -> float:
    certificate = tick.certificate
    if not certificate.accepted:
        return inf
    return float(np.max((certificate.primal_residual, certificate.dual_residual, certificate.gap)))
