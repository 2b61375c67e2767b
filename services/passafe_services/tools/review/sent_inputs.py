"""Check of what inputs say besides u: each beside the input before it, and beside the scenario."""

from collections.abc import Callable
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import UNSEQUENCED
from passafe_protocol.topics import INPUT
from passafe_protocol.validation import MAX_VECTOR

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.column import Column, joined, take
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.agreement import LogAgreement
from passafe_services.tools.review.trajectory import NS_PER_S

_NUMBERS: Final = (
    *("tick", "effective_plant_ns", "hold_ns", "input_sequence_start_ns", "known_break_ns", "stops_cleared"),
)


class SentInputCheck:
    """Check of the inputs of a run, as they come.

    Args:
        scenario: The scenario.
        m: Numbers of an input.
        agreement: Takes what cannot be so.
    """

    wants: ClassVar[Wants] = {INPUT.name: (*_NUMBERS, "u", "previous_u")}

    def __init__(self, scenario: Scenario, m: int, agreement: LogAgreement) -> None:
        self._agreement = agreement
        self._m = m
        self._hold_ns = round(scenario.plant.hold_s * NS_PER_S)
        self._is_predicted = scenario.filter.prediction
        self._repeats = min(scenario.filter.repeats, MAX_VECTOR // m) if scenario.filter.prediction else 0
        self._newest: dict[int, dict[str, Column]] = {}

    def take(self, part: LogSlice) -> None:
        """Take the next inputs."""
        for block in part.blocks(INPUT.name):
            self._take_rules(block)
            columns = {path: block.columns[path] for path in (*_NUMBERS, "u", "previous_u", "header.sequence")}
            before = self._newest.get(block.epoch)
            if before is not None:
                columns = {path: joined([before[path], column]) for path, column in columns.items()}
            last = np.array([len(columns["tick"]) - 1])
            self._newest[block.epoch] = {path: take(column, last) for path, column in columns.items()}
            self._take_changes(MessageBlock(block.topic, block.source, block.epoch, block.session, columns))

    def _take_rules(self, block: MessageBlock) -> None:
        refute = self._refuter(block)
        refute("another hold time than the scenario's", block.numbers("hold_ns") != np.uint64(self._hold_ns))
        unsequenced = block.numbers("input_sequence_start_ns") == UNSEQUENCED
        refute("an input of the other kind of plant", unsequenced if self._is_predicted else ~unsequenced)

    def _take_changes(self, block: MessageBlock) -> None:
        """Check each input that follows another by that one."""
        follows = np.diff(block.sequence.astype(np.int64), prepend=-2) == 1
        refute = self._refuter(block)

        def change(path: str) -> NDArray[np.int64]:
            column = block.numbers(path).astype(np.int64)
            found: NDArray[np.int64] = np.diff(column, prepend=column[:1])
            return found

        refute("stops_cleared goes back", follows & (change("stops_cleared") < 0))
        refute("another tick than the next", follows & (change("tick") != 1))
        if not self._is_predicted:
            return
        begins = block.numbers("input_sequence_start_ns") == block.numbers("effective_plant_ns")
        same = change("input_sequence_start_ns") == 0
        refute("a sequence that began at another time", follows & ~same & ~begins)
        inside = follows & same & ~begins
        refute("another sequence break within a sequence", inside & (change("known_break_ns") != 0))
        refute("copies of other inputs than those before", self._miscopied(block, inside, begins))

    def _miscopied(
        self, block: MessageBlock, inside: NDArray[np.bool_], begins: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return which inputs do not repeat those before them in their sequence, newest first."""
        u, copies = block.ragged("u"), block.ragged("previous_u")
        known = u.counts == self._m
        width = self._repeats * self._m
        if not width:
            return copies.counts > 0
        own, repeated = u.matrix(self._m), copies.matrix(width)
        expected = np.concatenate((own, repeated), axis=1)[:, :width]
        counts = np.minimum(copies.counts + self._m, width)
        wrong = np.zeros(len(block), dtype=np.bool_)
        within = np.arange(width) < counts[:-1, None]
        differs = ((repeated[1:] != expected[:-1]) & within).any(axis=1) | (copies.counts[1:] != counts[:-1])
        wrong[1:] = inside[1:] & known[1:] & known[:-1] & differs
        found: NDArray[np.bool_] = wrong | (begins & (copies.counts > 0))
        return found

    def _refuter(self, block: MessageBlock) -> Callable[[str, NDArray[np.bool_]], None]:
        ticks, at_s = block.numbers("tick"), block.numbers("effective_plant_ns") / NS_PER_S
        return lambda what, wrong: self._agreement.refute(
            what, wrong, at_s, lambda row: f"input of tick {int(ticks[row])}"
        )
