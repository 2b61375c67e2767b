"""Check of what ticks say of the messages that they consumed: ages, horizon, the operator's command."""

from typing import ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import UNKNOWN_CLOCK, CommandState
from passafe_protocol.topics import COMMAND, LINK_EVENT, LINKS, STATE, TICK, TOPIC_OF_NAME

from passafe_services.filter.newest_state import LONGEST_PERIOD_NS
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.schema import Scenario, WhiteAccelerationEstimator
from passafe_services.tools.review.agreement import LogAgreement
from passafe_services.tools.review.consumed_messages import MOST_KEPT, ConsumedMessages, LoggedMessages, Newest
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.trajectory import NS_PER_S

Rows = NDArray[np.bool_]

_WHOLLY: Final = ("loss", "outage")
"""Causes of a drop that leave no copy of the message."""

_HEADER: Final = ("header.scheduled_ns", "header.clock_id")


class _Ticks(NamedTuple):
    """Ticks of a block that wait until the messages that they consumed have come."""

    block: MessageBlock
    consumed: dict[str, ConsumedMessages]


class ConsumptionCheck:
    """Check of ticks beside the messages that they consumed, as both come.

    A session of the filter counts while it receives from one session of the plant, and one of the operator: who
    holds the lease is decided by more than the log's order. Ages are looked at where sender and filter read one clock.

    Args:
        scenario: The scenario.

    Attributes:
        agreement: What does not follow.
    """

    wants: ClassVar[Wants] = {
        TICK.name: (
            *("tick", "effective_plant_ns", "state_age_ns", "command_age_ns", "horizon_ns", "header.sent_ns"),
            *("command_state", "command_share", "u_h", "u_h_rate", *_HEADER),
            *(f"consumed.{name}" for name in ("topic", "sequence", "received_ns", "epoch", "term")),
        ),
        STATE.name: ("plant_ns", "stop", "stops_cleared", *_HEADER),
        LINK_EVENT.name: ("link", "cause", "sequence"),
        COMMAND.name: ("u_h", "u_h_rate", "enabled", *_HEADER),
    }

    def __init__(self, scenario: Scenario) -> None:
        self.agreement = LogAgreement("ticks that do not follow from the messages that they consumed = 0")
        robot = robot_of(scenario)
        self._m = robot.system.m
        self._is_predicted = scenario.filter.prediction
        self._stale_ns = round(scenario.operator.stale_s * NS_PER_S)
        is_estimated = isinstance(scenario.operator.estimator, WhiteAccelerationEstimator)
        self._passes_through = not is_estimated and robot.task is None
        self._sent = {
            STATE.name: LoggedMessages(("plant_ns", *_HEADER)),
            COMMAND.name: LoggedMessages(("enabled", *_HEADER), vectors={"u_h": self._m, "u_h_rate": self._m}),
        }
        self._newest = {name: Newest() for name in self._sent}
        self._waiting: list[_Ticks] = []
        self._dropped = {name: np.zeros(0, dtype=np.int64) for name in self._sent}
        self._terms: dict[tuple[int, int], int] = {}
        self._was_stopped = False
        self._whole: set[int] = set()

    def take(self, part: LogSlice) -> None:
        """Take the next messages; ticks wait for those of the next slice."""
        for name, sent in self._sent.items():
            for block in part.blocks(name):
                sent.add(block)
        for block in part.blocks(STATE.name):
            self._was_stopped |= bool(((block.numbers("stop") != 0) | (block.numbers("stops_cleared") != 0)).any())
        self._take_drops(part)
        waiting, self._waiting = self._waiting, []
        for ticks in waiting:
            self._check(ticks)
        for block in part.blocks(TICK.name):
            self._waiting.append(_Ticks(block, {name: ConsumedMessages.of(block, name) for name in self._sent}))
            self._take_consumed(block)
            if not int(block.sequence[0]):
                self._whole.add(block.epoch)

    def finish(self) -> LogAgreement:
        """Check what waits, and return the agreement."""
        waiting, self._waiting = self._waiting, []
        for ticks in waiting:
            self._check(ticks)
        for name, newest in self._newest.items():
            for epoch, tick in newest.epochs.items():
                if self._sent[name].sessions and not self._sent[name].knows(epoch):
                    text = f"tick {tick}: consumed a {name} of a session of which the log has no message"
                    self.agreement.note("session", text)
        return self.agreement

    def _take_drops(self, part: LogSlice) -> None:
        """Remember the numbers of messages that links to the filter dropped."""
        for block in part.blocks(LINK_EVENT.name):
            dropped = block.texts("cause").are(*_WHOLLY)
            for name, numbers in self._dropped.items():
                links = [link for link, place in LINKS.items() if place == (TOPIC_OF_NAME[name], "filter")]
                rows = dropped & block.texts("link").are(*links)
                found = block.numbers("sequence")[rows].astype(np.int64)
                self._dropped[name] = np.concatenate((numbers, found))[-MOST_KEPT:]

    def _take_consumed(self, block: MessageBlock) -> None:
        """Check what ticks say of each message that they consumed."""
        ticks, at_s = block.numbers("tick"), block.numbers("effective_plant_ns") / NS_PER_S
        received = block.ragged("consumed.received_ns")
        row = received.row_numbers

        def refute(what: str, wrong: Rows) -> None:
            of_tick = np.zeros(len(block), dtype=np.bool_)
            of_tick[row[wrong]] = True
            self.agreement.refute(what, of_tick, at_s, lambda number: f"tick {int(ticks[number])}")

        known = block.texts("consumed.topic").are(*self._sent)
        refute("a message of a topic that the filter does not read", ~known)
        refute("a message that came after the tick was sent", received.values > block.numbers("header.sent_ns")[row])
        refute("another term of a session", self._other_terms(block))

    def _other_terms(self, block: MessageBlock) -> Rows:
        """Return which consumed messages count the changes of session otherwise than others of their session."""
        epochs, terms = block.ragged("consumed.epoch").values, block.ragged("consumed.term").values
        found = np.zeros(epochs.size, dtype=np.bool_)
        for epoch in np.unique(epochs).tolist():
            of_epoch = epochs == epoch
            term = self._terms.setdefault((block.epoch, epoch), int(terms[of_epoch][0]))
            found |= of_epoch & (terms != term)
        return found

    def _check(self, ticks: _Ticks) -> None:
        block = ticks.block
        numbers = block.numbers("tick").astype(np.int64)
        at_s = block.numbers("effective_plant_ns") / NS_PER_S
        for name, consumed in ticks.consumed.items():
            newest = self._newest[name]
            twice = consumed.twice(len(block))
            self.agreement.refute(f"a {name} was consumed twice", twice, at_s, lambda row: f"tick {int(numbers[row])}")
            if self._sent[name].sessions == 1:  # else numbers of one are those of another
                lost = np.zeros(len(block), dtype=np.bool_)
                lost[consumed.row[np.isin(consumed.sequence, self._dropped[name])]] = True
                what = f"a {name} was consumed that its link dropped"
                self.agreement.refute(what, lost, at_s, lambda row: f"tick {int(numbers[row])}")
            received = newest.follow(block.epoch, consumed, numbers)
            if received is None:
                self.agreement.left_out += len(block)
                continue
            epoch, sequence, received_ns = received
            sent, known = self._sent[name].find(epoch, sequence)
            if name == STATE.name:  # the filter leaves out states that come from too far ahead in plant time
                known &= self._sent[name].follow(epoch, sequence, "plant_ns", LONGEST_PERIOD_NS)
            if block.epoch in self._whole:
                of_none = (sequence < 0) & (block.numbers(f"{name}_age_ns") >= 0)
                self.agreement.refute(f"an age of no {name}", of_none, at_s, lambda row: f"tick {int(numbers[row])}")
            now_ns = block.numbers("header.scheduled_ns")
            same_clock = known & (sent["header.clock_id"] == block.numbers("header.clock_id"))
            same_clock &= sent["header.clock_id"] != UNKNOWN_CLOCK
            age_ns = np.maximum(now_ns - sent["header.scheduled_ns"], 0)
            self._compare(block, f"age of the {name}, ns,", f"{name}_age_ns", age_ns, same_clock)
            if name == STATE.name:
                self._take_horizon(block, sent["plant_ns"], known)
            else:
                self._take_request(block, sent, same_clock, age_ns, received_ns - sent["header.scheduled_ns"])

    def _take_horizon(self, block: MessageBlock, plant_ns: IntArray, known: Rows) -> None:
        """Compare horizons."""
        expected = block.numbers("effective_plant_ns") - plant_ns
        if self._is_predicted:
            self._compare(block, "horizon, ns,", "horizon_ns", expected, known & _decided(block))

    def _take_request(
        self,
        block: MessageBlock,
        sent: dict[str, NDArray[np.generic]],
        known: Rows,
        age_ns: IntArray,
        late_ns: IntArray,
    ) -> None:
        """Check the operator's part of ticks by the newest command."""
        ticks, at_s = block.numbers("tick"), block.numbers("effective_plant_ns") / NS_PER_S
        counts = block.texts("command_state").are(CommandState.COUNTS)
        in_time = known & (late_ns <= self._stale_ns)

        def refute(what: str, wrong: Rows) -> None:
            self.agreement.refute(what, wrong, at_s, lambda row: f"tick {int(ticks[row])}")

        refute("a command that counts, and was released", in_time & counts & ~sent["enabled"].astype(np.bool_))
        refute("a command that counts, and is too old", in_time & counts & (age_ns > self._stale_ns))
        fresh = in_time & (age_ns <= self._stale_ns) & sent["enabled"].astype(np.bool_)
        without_command = block.texts("command_state").are(CommandState.SILENT, CommandState.DELAYED, CommandState.NONE)
        refute("a command that does not count, and is fresh", fresh & without_command)
        released = block.texts("command_state").are(CommandState.RELEASED, CommandState.STOPPED)
        refute("a command that was released, and is held", fresh & released & (not self._was_stopped))
        share = block.numbers("command_share")
        refute("a share of a command that counts in full", counts & (share != 1.0))
        if self._passes_through:
            for path in ("u_h", "u_h_rate"):
                asked: FloatArray = block.ragged(path).matrix(self._m)
                difference = np.abs(asked - np.nan_to_num(sent[path])).max(axis=1)
                difference[~(in_time & counts & _decided(block))] = 0.0
                self.agreement.compare(path, difference, at_s, 0.0, lambda row: f"tick {int(ticks[row])}")

    def _compare(self, block: MessageBlock, what: str, path: str, expected: IntArray, known: Rows) -> None:
        ticks, at_s = block.numbers("tick"), block.numbers("effective_plant_ns") / NS_PER_S
        difference = np.where(known, np.abs(block.numbers(path) - expected), 0).astype(np.float64)
        self.agreement.compare(what, difference, at_s, 0.0, lambda row: f"tick {int(ticks[row])}")


def _decided(block: MessageBlock) -> Rows:
    """Return which ticks are surely of new decisions: a step without one repeats the last."""
    ticks = block.numbers("tick").astype(np.int64)
    found: Rows = np.diff(ticks, prepend=-1) != 0
    found[:1] = False  # perhaps a repeat of the last one of the block before
    return found
