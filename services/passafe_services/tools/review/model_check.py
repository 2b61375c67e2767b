"""Check of the assumption of the rows: every state against what the scenario's sets allow from those before."""

from dataclasses import dataclass, field
from typing import ClassVar

from passafe_protocol.messages import PlantPhase
from passafe_protocol.topics import STATE

from passafe.state_set import ErrorGrowth
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.plant_contract.state_estimate import StateEstimate
from passafe_services.tools.review.property import Property, Violation
from passafe_services.tools.review.trajectory import NS_PER_S

MOST_LISTED = 5
"""Violations that a property lists."""


@dataclass(kw_only=True, eq=False)
class _Session:
    """One session of the plant.

    Attributes:
        estimate: Box of its newest state.
        before: Sequence number, phase and input of its newest state.
    """

    estimate: StateEstimate
    before: tuple[int, int, tuple[float, ...]] | None = field(default=None)


class ModelCheck:
    """Check of the states of a run against the scenario's sets, as they come; the filter's own watch is not trusted.

    Args:
        growth: Growth of errors by the sets; ``None`` for a scenario without.
        n: Numbers of a state.
        m: Numbers of an input.

    Attributes:
        compared: States that were compared with the ones before them.
        violated: Those outside of what the sets allow.
    """

    wants: ClassVar[Wants] = {STATE.name: ("plant_ns", "x", "u", "phase")}

    def __init__(self, growth: ErrorGrowth | None, n: int, m: int) -> None:
        self._growth = growth
        self._n, self._m = n, m
        self._sessions: dict[int, _Session] = {}
        self.compared = self.violated = 0
        self._worst: tuple[float, float] | None = None
        self._listed: list[Violation] = []

    def take(self, part: LogSlice) -> None:
        """Take the next states."""
        growth = self._growth
        if growth is None:
            return
        for block in part.blocks(STATE.name):
            session = self._sessions.setdefault(block.epoch, _Session(estimate=StateEstimate(growth)))
            self._take(block, session)

    def property(self) -> Property:
        """Return the property that no state lies outside of what the sets allow; required where there are sets."""
        worst, at_s = (None, None) if self._worst is None else self._worst
        note = ""
        if self.violated:
            note = f"MODEL_VIOLATED: {self.violated} of {self.compared} states outside of what the sets allow, "
            note += f"up to {worst:.3g} times as far, first at {self._listed[0].at_s:.3f} s"
        return Property(
            holds=None if worst is None else not self.violated,
            required=self._growth is not None,
            worst=worst,
            at_s=at_s,
            requirement="distance of each state from the middle of what the sets allow from those before, factor ≤ 1",
            allowed="≤ 1",
            note=note,
            count=self.violated if self._growth is not None else None,
            violations=tuple(self._listed),
        )

    def _take(self, block: MessageBlock, session: _Session) -> None:
        rows = zip(
            block.sequence.tolist(),
            block.numbers("plant_ns").tolist(),
            block.numbers("phase").tolist(),
            map(tuple, block.matrix("x", self._n).T.tolist()),
            map(tuple, block.matrix("u", self._m).T.tolist()),
            strict=True,
        )
        for sequence, plant_ns, phase, x, u in rows:
            before, session.before = session.before, (sequence, phase, u)
            follows = before is not None and before[0] + 1 == sequence and before[1] != PlantPhase.WAITING
            estimate = session.estimate
            estimate.observe(x, (before[2],) if before is not None and follows else None)
            if estimate.residual:
                self._judge(max(estimate.residual), estimate.residual, plant_ns / NS_PER_S)

    def _judge(self, factor: float, factors: tuple[float, ...], at_s: float) -> None:
        self.compared += 1
        if self._worst is None or factor > self._worst[0]:
            self._worst = factor, at_s
        if factor <= 1.0:
            return
        self.violated += 1
        if len(self._listed) < MOST_LISTED:
            axis = factors.index(factor)
            self._listed.append(Violation(at_s=at_s, text=f"x[{axis}] lies {factor:.3g} times as far as allowed"))
