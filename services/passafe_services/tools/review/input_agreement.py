"""Check that the inputs sent are those decided: each PlantInput beside the tick of the same number."""

from typing import ClassVar, NamedTuple

import numpy as np
from passafe_protocol.topics import INPUT, TICK

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.agreement import LogAgreement
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.time_order import MOST_WAITING
from passafe_services.tools.review.trajectory import NS_PER_S


class _Numbered(NamedTuple):
    """Inputs by the numbers of their ticks.

    Attributes:
        tick: Numbers, shape (K,).
        at_ns: Plant times at which they take effect, ns, shape (K,).
        u: Inputs, shape (m, K); NaN for one with another number of axes.
    """

    tick: IntArray
    at_ns: IntArray
    u: FloatArray

    def take(self, rows: IntArray) -> "_Numbered":
        return _Numbered(self.tick[rows], self.at_ns[rows], self.u[:, rows])

    def followed_by(self, other: "_Numbered") -> "_Numbered":
        parts = np.concatenate((self.tick, other.tick)), np.concatenate((self.at_ns, other.at_ns))
        return _Numbered(*parts, np.concatenate((self.u, other.u), axis=1))


class InputAgreement:
    """Inputs sent beside inputs decided, as both come.

    Args:
        m: Numbers of an input.

    Attributes:
        agreement: Differences.
    """

    wants: ClassVar[Wants] = {
        INPUT.name: ("tick", "u", "effective_plant_ns"),
        TICK.name: ("tick", "u", "effective_plant_ns"),
    }

    def __init__(self, m: int) -> None:
        self.agreement = LogAgreement("inputs sent that differ from those that their ticks decided = 0")
        self._m = m
        none = np.zeros(0, dtype=np.int64)
        self._none = _Numbered(none, none, np.zeros((m, 0)))
        self._sent: dict[int, _Numbered] = {}
        self._decided: dict[int, _Numbered] = {}
        self._newest: dict[int, int] = {}

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for name, waiting in ((INPUT.name, self._sent), (TICK.name, self._decided)):
            for block in part.blocks(name):
                waiting[block.epoch] = waiting.get(block.epoch, self._none).followed_by(self._numbered(block))
        for epoch in self._sent.keys() & self._decided.keys():
            self._compare(epoch)

    def finish(self, most_missing: int) -> LogAgreement:
        """Note inputs without their ticks at the end of a session, and return the agreement.

        Args:
            most_missing: Ticks that may be missing there: those of the last step of a filter that was killed.
        """
        for epoch, sent in self._sent.items():
            decided = self._decided.get(epoch, self._none)
            newest = int(decided.tick[-1]) if decided.tick.size else self._newest.get(epoch, 0)
            missing = np.unique(sent.tick[sent.tick > newest])
            if missing.size > most_missing:
                text = f"input of tick {int(missing[0])} and {missing.size - 1} after it: the log has no such tick"
                self.agreement.note(
                    "inputs without a tick", text, float(sent.at_ns[sent.tick == missing[0]][0]) / NS_PER_S
                )
        self._sent = {}
        return self.agreement

    def _numbered(self, block: MessageBlock) -> _Numbered:
        vectors = block.ragged("u")
        u = vectors.matrix(self._m).T.copy()
        u[:, vectors.counts != self._m] = np.nan
        return _Numbered(block.numbers("tick").astype(np.int64), block.numbers("effective_plant_ns"), u)

    def _compare(self, epoch: int) -> None:
        sent, decided = self._sent[epoch], self._decided[epoch]
        known = np.isin(sent.tick, decided.tick)
        numbers, first = np.unique(decided.tick, return_index=True)
        rows = np.flatnonzero(known)
        if rows.size:
            ours = sent.take(rows)
            theirs = decided.take(first[np.searchsorted(numbers, ours.tick)])
            at_s = ours.at_ns / NS_PER_S

            def name(row: int) -> str:
                return f"input of tick {int(ours.tick[row])}"

            self.agreement.compare("u", np.abs(ours.u - theirs.u).max(axis=0), at_s, 0.0, name)
            late_s = np.abs(ours.at_ns - theirs.at_ns) / NS_PER_S
            self.agreement.compare("time of effect, s,", late_s, at_s, 0.0, name)
        newest = int(decided.tick[-1]) if decided.tick.size else 0
        self._newest[epoch] = max(newest, self._newest.get(epoch, 0))
        self._repeats(decided)
        self._sent[epoch] = sent.take(np.flatnonzero(sent.tick > newest)[-MOST_WAITING:])
        last = int(sent.tick[-1]) if sent.tick.size else 0
        self._decided[epoch] = decided.take(np.flatnonzero(decided.tick >= last)[-MOST_WAITING:])

    def _repeats(self, decided: _Numbered) -> None:
        """Compare ticks of steps without a new decision to the decision that they repeat."""
        rows = np.flatnonzero(np.diff(decided.tick) == 0)
        if rows.size:
            again, before = decided.take(rows + 1), decided.take(rows)
            difference = np.abs(again.u - before.u).max(axis=0)
            at_s = again.at_ns / NS_PER_S
            self.agreement.compare("u", difference, at_s, 0.0, lambda row: f"repeat of tick {int(again.tick[row])}")
