"""Origin of the inputs in force: decisions of the filter whose ticks are in the log, or somebody else's."""

from typing import ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantPhase
from passafe_protocol.topics import STATE, TICK

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.column import Places, Ragged
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.agreement import LogAgreement, relative
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.time_order import MOST_WAITING
from passafe_services.tools.review.trajectory import NS_PER_S

RUNNING = PlantPhase.RUNNING

PREDICTED: Final = 1e-6
"""Relative difference between a predicted and a true state that rounding may leave."""


class ForeignInputs(NamedTuple):
    """States in which an input was in force that no tick in the log decided.

    Attributes:
        states: Their number.
        first_s: Plant time of the first, s.
    """

    states: int
    first_s: float


class _Applied(NamedTuple):
    """Inputs in force whose ticks are looked for.

    Attributes:
        ticks: Numbers of the ticks, shape (N,).
        u: The inputs.
        plant_ns: Plant times, ns, shape (N,).
        x: States, shape (N, n).
    """

    ticks: NDArray[np.uint64]
    u: Ragged
    plant_ns: IntArray
    x: FloatArray

    def take(self, rows: Places) -> "_Applied":
        return _Applied(self.ticks[rows], self.u.take(rows), self.plant_ns[rows], self.x[rows])

    def followed_by(self, other: "_Applied") -> "_Applied":
        return _Applied(
            np.concatenate((self.ticks, other.ticks)),
            Ragged.joined([self.u, other.u]),
            np.concatenate((self.plant_ns, other.plant_ns)),
            np.concatenate((self.x, other.x)),
        )


class OriginRecord:
    """Origin of the inputs in force, as states and ticks come.

    A tick that is missing in the log decided its input all the same: what is missing is counted elsewhere.

    Args:
        n: Numbers of a state.
        is_predicted: Whether the filter predicts the state at which an input takes effect.

    Attributes:
        agreement: Differences between the states at which inputs took effect and those that were predicted.
    """

    wants: ClassVar[Wants] = {
        TICK.name: ("tick", "u", "x_hat", "effective_plant_ns"),
        STATE.name: ("phase", "input_epoch", "applied_tick", "u", "u_asked", "plant_ns", "x"),
    }

    def __init__(self, n: int, *, is_predicted: bool) -> None:
        self.agreement = LogAgreement("inputs in force whose tick predicted another state or another time = 0")
        self._n = n
        self._is_predicted = is_predicted
        self._decided: dict[int, _Decided] = {}
        self._waiting: dict[int, _Applied] = {}
        self._states = 0
        self._first_ns: int | None = None

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for block in part.blocks(TICK.name):
            found = _Decided(
                block.numbers("tick"),
                block.ragged("u"),
                block.ragged("x_hat").matrix(self._n),
                block.numbers("effective_plant_ns"),
            )
            before = self._decided.get(block.epoch)
            self._decided[block.epoch] = found if before is None else before.followed_by(found)
        for block in part.blocks(STATE.name):
            self._take_phases(block)
            epochs = block.numbers("input_epoch")
            runs = (block.numbers("phase") == RUNNING) & (epochs != 0)  # 0: a log of an earlier version
            for epoch in np.unique(epochs[runs]).tolist():
                rows = np.flatnonzero(runs & (epochs == epoch))
                applied = _Applied(
                    block.numbers("applied_tick")[rows],
                    inputs_asked(block).take(rows),
                    block.numbers("plant_ns")[rows],
                    block.ragged("x").matrix(self._n)[rows],
                )
                waiting = self._waiting.get(epoch)
                self._judge(epoch, applied if waiting is None else waiting.followed_by(applied), is_end=False)

    def _take_phases(self, block: MessageBlock) -> None:
        """Note states with an input of the filter in force before there was any."""
        without = (block.numbers("phase") == RUNNING) & (block.numbers("applied_tick") == 0)
        sequence = block.sequence
        at_s = block.numbers("plant_ns") / NS_PER_S
        for row in np.flatnonzero(without).tolist():
            text = f"state {int(sequence[row])}: phase RUNNING, but no input of the filter had taken effect"
            self.agreement.note("phase", text, float(at_s[row]))

    def foreign(self) -> ForeignInputs | None:
        """Return the states with an input of somebody else than the filter; ``None`` if there is none."""
        for epoch, applied in [*self._waiting.items()]:
            self._judge(epoch, applied, is_end=True)
        self._waiting = {}
        return None if self._first_ns is None else ForeignInputs(self._states, self._first_ns / NS_PER_S)

    def _judge(self, epoch: int, applied: _Applied, *, is_end: bool) -> None:
        """Judge states of which the tick has come or will not come, and let the others wait."""
        decided = self._decided.get(epoch)
        newest = decided.ticks[-1] if decided is not None else np.uint64(0)
        waits = (applied.ticks > newest) & (not is_end)
        if waits.sum() > MOST_WAITING:
            waits[:] = False
        rows = np.flatnonzero(~waits)
        self._waiting[epoch] = applied.take(np.flatnonzero(waits))
        if not rows.size:
            return
        settled = applied.take(rows)
        is_foreign = np.ones(rows.size, dtype=np.bool_) if decided is None else decided.contradicts(settled)
        if decided is not None and self._is_predicted:
            self._compare(decided, settled)
        self._states += int(is_foreign.sum())
        if is_foreign.any():
            first_ns = int(settled.plant_ns[is_foreign].min())
            self._first_ns = first_ns if self._first_ns is None else min(self._first_ns, first_ns)

    def _compare(self, decided: "_Decided", applied: _Applied) -> None:
        """Compare states at which inputs took effect with what their ticks predicted."""
        place, known = decided.find(applied.ticks)
        in_force = applied.take(np.flatnonzero(known))
        at_s = in_force.plant_ns / NS_PER_S

        def name(row: int) -> str:
            return f"tick {int(in_force.ticks[row])}"

        late_s = np.abs(in_force.plant_ns - decided.at_ns[place]) / NS_PER_S
        wrong = self.agreement.compare("time of effect, s,", late_s, at_s, 0.0, name)
        difference = relative(decided.x_hat[place].T, in_force.x.T)
        difference[wrong] = 0.0  # it is another state
        self.agreement.compare("predicted state", difference, at_s, PREDICTED, name)


def inputs_asked(block: MessageBlock) -> Ragged:
    """Return the inputs that the plant was asked for: those in force, unless its guard has changed them."""
    in_force, asked = block.ragged("u"), block.ragged("u_asked")
    changed = asked.counts > 0
    if not changed.any():
        return in_force
    counts = np.where(changed, asked.counts, in_force.counts)
    width = int(counts.max())
    both = np.where(changed[:, None], asked.matrix(width), in_force.matrix(width))
    return Ragged(both[np.arange(width) < counts[:, None]], counts)


class _Decided(NamedTuple):
    """Decisions of one session of the filter, the newest ones.

    Attributes:
        ticks: Numbers, in order, shape (K,).
        u: The inputs.
        x_hat: Predicted states, shape (K, n).
        at_ns: Plant times at which they take effect, ns, shape (K,).
    """

    ticks: NDArray[np.uint64]
    u: Ragged
    x_hat: FloatArray
    at_ns: IntArray

    def followed_by(self, other: "_Decided") -> "_Decided":
        kept = np.arange(max(len(self.ticks) - MOST_WAITING, 0), len(self.ticks))
        return _Decided(
            np.concatenate((self.ticks[kept], other.ticks)),
            Ragged.joined([self.u.take(kept), other.u]),
            np.concatenate((self.x_hat[kept], other.x_hat)),
            np.concatenate((self.at_ns[kept], other.at_ns)),
        )

    def find(self, ticks: NDArray[np.uint64]) -> tuple[Places, NDArray[np.bool_]]:
        """Return the places of the ticks that are here, and which are."""
        place = np.searchsorted(self.ticks, ticks, side="left")
        known = place < len(self.ticks)
        known[known] = self.ticks[place[known]] == ticks[known]
        return place[known], known

    def contradicts(self, applied: "_Applied") -> NDArray[np.bool_]:
        """Return which inputs in force are not those of their ticks, shape (N,)."""
        place, known = self.find(applied.ticks)
        decided, in_force = self.u.take(place), applied.u.take(np.flatnonzero(known))
        width = int(max(decided.counts.max(initial=0), in_force.counts.max(initial=0)))
        same = (decided.counts == in_force.counts) & (
            (decided.matrix(width) == in_force.matrix(width)) | (np.arange(width) >= decided.counts[:, None])
        ).all(axis=1)
        found: NDArray[np.bool_] = np.zeros(len(applied.ticks), dtype=np.bool_)
        found[known] = ~same
        return found


def driven_by_the_filter(driven: Property, foreign: ForeignInputs | None) -> Property:
    """Return the property that the robot could be driven, violated if somebody else drove it."""
    if foreign is None:
        return driven
    said = f"the robot was driven by another: {foreign.states} states with an input that no tick of the log decided"
    note = f"{said}, first at {foreign.first_s:.3f} s"
    both = f"{driven.note}, {note}" if driven.note else note
    return driven.model_copy(update={"holds": False, "note": both, "at_s": foreign.first_s})
