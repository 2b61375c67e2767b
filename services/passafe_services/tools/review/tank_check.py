"""Check of the tank of the filter's ticks: each tick's energy follows from that of the tick before and its input."""

from typing import ClassVar, Final

import numpy as np
from passafe_protocol.topics import TICK

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.schema import PassivityConfig
from passafe_services.tools.review.agreement import LogAgreement, relative
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.trajectory import NS_PER_S

ROUNDING: Final = 1e-9
"""Relative difference that rounding may leave between the filter's own numbers and recomputed ones."""


class TankCheck:
    """Check of the tank in the ticks of a run, as they come.

    A tick counts if its state is the one to which the input of the tick before leads: then nothing came between them.

    Args:
        evaluator: Functions of the scenario.
        passivity: The tank.
        period_s: Period of a tick, s.
        n: Numbers of a state.
        m: Numbers of an input.

    Attributes:
        agreement: Differences.
    """

    wants: ClassVar[Wants] = {TICK.name: ("tick", "x_hat", "u", "tank_j", "effective_plant_ns")}

    def __init__(
        self, evaluator: PlantEvaluator, passivity: PassivityConfig, *, period_s: float, n: int, m: int
    ) -> None:
        self.agreement = LogAgreement("energies in the tank of ticks that do not follow from the tick before = 0")
        self._evaluator = evaluator
        self._passivity = passivity
        self._period_s = period_s
        self._n, self._m = n, m
        self._newest: dict[int, tuple[IntArray, FloatArray]] = {}

    def take(self, part: LogSlice) -> None:
        """Take the next ticks."""
        for block in part.blocks(TICK.name):
            self._take(block)

    def _take(self, block: MessageBlock) -> None:
        numbers = np.stack([block.numbers(path).astype(np.int64) for path in ("tick", "effective_plant_ns")])
        x, u = block.ragged("x_hat").matrix(self._n).T, block.ragged("u").matrix(self._m).T
        values = np.concatenate((block.numbers("tank_j")[None], x, u))
        if block.epoch in self._newest:
            before = self._newest[block.epoch]
            numbers = np.concatenate((before[0], numbers), axis=1)
            values = np.concatenate((before[1], values), axis=1)
        self._newest[block.epoch] = numbers[:, -1:], values[:, -1:]
        first = np.flatnonzero((numbers[0] == 1) & (numbers[1] == 0))[:1]
        self._compare(numbers[:, first], values[0, first], np.full(first.size, self._passivity.tank_initial_j))
        (rows,) = np.nonzero(
            (np.diff(numbers[0]) == 1) & (np.abs(np.diff(numbers[1]) - self._period_s * NS_PER_S) <= 1)
        )
        x, u = values[1 : 1 + self._n, rows], values[1 + self._n :, rows]
        with np.errstate(over="ignore", invalid="ignore"):
            reached = self._evaluator.flow(x, u, self._period_s)
            gained_j = self._evaluator.energy_gain(x, u, self._period_s)
        follows = relative(values[1 : 1 + self._n, rows + 1], reached) <= ROUNDING
        rows, gained_j = rows[follows], gained_j[follows]
        expected = np.minimum(values[0, rows] + gained_j, self._passivity.tank_max_j)
        self._compare(numbers[:, rows + 1], values[0, rows + 1], expected)

    def _compare(self, numbers: IntArray, tank_j: FloatArray, expected_j: FloatArray) -> None:
        difference = relative(tank_j[None], expected_j[None])
        at_s = numbers[1] / NS_PER_S
        self.agreement.compare("tank", difference, at_s, ROUNDING, lambda row: f"tick {int(numbers[0, row])}")
