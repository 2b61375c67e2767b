"""Latency from a command's sending to the first step of the plant with an input based on it, as messages come."""

from typing import Final

import numpy as np
from passafe_protocol.messages import PlantPhase
from passafe_protocol.topics import COMMAND, STATE, TICK

from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.duration_histogram import DurationHistogram
from passafe_services.tools.review.filter_claims import IntArray

MOST_KEPT: Final = 1 << 17
"""Commands, states and ticks that are kept until their counterparts come: two minutes at 1 kHz."""


class CommandLatency:
    """Latencies of commands.

    Without sessions of one filter and one plant, tick numbers are ambiguous; without one clock, wall times are. Then
    nothing is known.
    """

    def __init__(self) -> None:
        self._sent: dict[int, tuple[IntArray, IntArray]] = {}
        self._clocks: set[int] = set()
        self._sessions: tuple[set[tuple[str, int]], set[tuple[str, int]]] = (set(), set())
        self._ticks: IntArray = np.zeros((2, 0), dtype=np.int64)  # tick, wall time of a command that it consumed
        self._states: IntArray = np.zeros((2, 0), dtype=np.int64)  # newest tick applied, wall time of the step
        self._is_first = True
        self._durations = DurationHistogram()

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for block in part.blocks(COMMAND.name):
            self._take_commands(block)
        for block in part.blocks(TICK.name):
            self._take_ticks(block)
        for block in part.blocks(STATE.name):
            self._take_states(block)
        self._resolve()

    def histogram(self) -> DurationHistogram:
        """Return the latencies; none if they are not known."""
        is_known = all(len(of) == 1 for of in self._sessions) and len(self._clocks) <= 1
        return self._durations if is_known else DurationHistogram()

    def _take_commands(self, block: MessageBlock) -> None:
        self._clocks |= set(np.unique(block.numbers("header.clock_id")).tolist())
        found = (block.sequence.astype(np.int64), block.numbers("header.wall_ns"))
        before = self._sent.get(block.epoch)
        parts = found if before is None else (np.concatenate(pair) for pair in zip(before, found, strict=True))
        numbers, walls = (part[-MOST_KEPT:] for part in parts)
        self._sent[block.epoch] = numbers, walls

    def _take_ticks(self, block: MessageBlock) -> None:
        self._sessions[0].add((block.source, block.epoch))
        numbers, epochs = block.ragged("consumed.sequence"), block.ragged("consumed.epoch").values
        wanted = block.texts("consumed.topic").are(COMMAND.name)
        rows = numbers.row_numbers[wanted]
        if self._is_first:  # the first accounts for all commands that came before there was a robot to move
            wanted[: int(numbers.counts[0])] = False
            rows, self._is_first = numbers.row_numbers[wanted], False
        ticks = block.numbers("tick").astype(np.int64)[rows]
        for epoch in np.unique(epochs[wanted]).tolist():
            if epoch in self._sent:
                of_epoch = epochs[wanted] == epoch
                self._add(ticks[of_epoch], numbers.values[wanted][of_epoch].astype(np.int64), *self._sent[epoch])

    def _add(self, ticks: IntArray, consumed: IntArray, numbers: IntArray, walls: IntArray) -> None:
        place = np.minimum(np.searchsorted(numbers, consumed), numbers.size - 1)
        known = numbers[place] == consumed
        found = np.stack((ticks[known], walls[place[known]]))
        self._ticks = np.concatenate((self._ticks, found), axis=1)[:, -MOST_KEPT:]

    def _take_states(self, block: MessageBlock) -> None:
        moves = block.numbers("phase") != PlantPhase.WAITING
        if not moves.any():
            return
        self._sessions[1].add((block.source, block.epoch))
        self._clocks |= set(np.unique(block.numbers("header.clock_id")[moves]).tolist())
        applied = block.numbers("applied_tick").astype(np.int64)[moves]
        newest = int(self._states[0, -1]) if self._states.size else 0
        worked_ns = block.numbers("header.sent_ns") - block.numbers("header.started_ns")
        begun_ns = (block.numbers("header.wall_ns") - worked_ns)[moves]
        found = np.stack((np.maximum(np.maximum.accumulate(applied), newest), begun_ns))
        self._states = np.concatenate((self._states, found), axis=1)[:, -MOST_KEPT:]

    def _resolve(self) -> None:
        if not self._states.size or not self._ticks.size:
            return
        at = np.searchsorted(self._states[0], self._ticks[0])
        known = at < self._states.shape[1]
        self._durations.add(self._states[1, at[known]] - self._ticks[1, known])
        self._ticks = self._ticks[:, ~known]
