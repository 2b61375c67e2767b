"""Check of what states report besides the motion, beside the state before each and the rules of the plant."""

from collections.abc import Callable
from functools import cache
from typing import ClassVar, Final, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import GuardAction, PlantPhase
from passafe_protocol.topics import STATE

from passafe.batch.batch_function import BatchFunction
from passafe.numerics.workspace import dense_function
from passafe.sampled_plant import LOCAL_TOLERANCE
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.agreement import LogAgreement, relative
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.input_origin import inputs_asked
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.trajectory import NS_PER_S

Rows = NDArray[np.bool_]

ROUNDING: Final = 1e-9
"""Relative difference that rounding may leave between the plant's own numbers and recomputed ones."""

_COUNTS: Final = ("inputs_late", "inputs_refused", "stops_cleared", "guarded", "plant_ns", "sequence_break_ns")
"""Fields that never go back in a session of the plant."""

_OF_FILTER: Final = ("applied_tick", "received_tick")
"""Fields that never go back while the inputs are of one session of the filter."""

_INTEGERS: Final = (*_COUNTS, *_OF_FILTER, "input_since_ns", "input_lead_ns", "phase", "input_epoch", "stop")


class _Reports(NamedTuple):
    """States of a session, the last one of the block before as the first.

    Attributes:
        sequence: Their numbers, shape (N,).
        of: Columns of integers by field, shape (N,) each.
        acts: Whether the guard did something about the input, shape (N,).
        asked: Inputs that the guard was asked to pass, or that are in force, shape (m, N).
    """

    sequence: IntArray
    of: dict[str, IntArray]
    acts: Rows
    asked: FloatArray

    def last(self) -> "_Reports":
        last = slice(-1, None)
        return _Reports(
            self.sequence[last], {path: of[last] for path, of in self.of.items()}, self.acts[last], self.asked[:, last]
        )

    def followed_by(self, other: "_Reports") -> "_Reports":
        return _Reports(
            np.concatenate((self.sequence, other.sequence)),
            {path: np.concatenate((of, other.of[path])) for path, of in self.of.items()},
            np.concatenate((self.acts, other.acts)),
            np.concatenate((self.asked, other.asked), axis=1),
        )


class StateReportCheck:
    """Check of the reports of a run's states, as they come.

    Args:
        scenario: The scenario.
        agreement: Takes what cannot be so.
    """

    wants: ClassVar[Wants] = {
        STATE.name: (
            *_INTEGERS,
            *("x", "u", "u_asked", "guard", "guard_cause", "stop_source", "integration_error"),
        )
    }

    def __init__(self, scenario: Scenario, agreement: LogAgreement) -> None:
        self._agreement = agreement
        robot = robot_of(scenario)
        self._n, self._m = robot.system.n, robot.system.m
        self._is_predicted, self._has_guard = scenario.filter.prediction, scenario.has_guard
        self._period_ns = round(scenario.dt_s * NS_PER_S)
        self._law = cache(lambda: _fail_safe_law(scenario))
        self._newest: dict[int, _Reports] = {}

    def take(self, part: LogSlice) -> None:
        """Take the next states."""
        for block in part.blocks(STATE.name):
            self._take_rules(block)
            found = self._reports(block)
            before = self._newest.get(block.epoch)
            found = found if before is None else before.followed_by(found)
            self._newest[block.epoch] = found.last()
            self._take_changes(found)

    def _reports(self, block: MessageBlock) -> _Reports:
        acts = block.texts("guard").are(GuardAction.CHANGED, GuardAction.FAIL_SAFE)
        of = {path: block.numbers(path).astype(np.int64) for path in _INTEGERS}
        asked = inputs_asked(block).matrix(self._m).T
        return _Reports(block.sequence.astype(np.int64), of, acts, asked)

    def _take_rules(self, block: MessageBlock) -> None:
        """Check what each state says by itself."""
        phase, plant_ns = block.numbers("phase"), block.numbers("plant_ns")
        refute = self._refuter(block.sequence.astype(np.int64), plant_ns)
        stopped = block.numbers("stop") != 0
        refute("an emergency stop of nobody, or nobody's", stopped == block.texts("stop_source").are(""))
        guard, cause = block.texts("guard"), ~block.texts("guard_cause").are("")
        acts = guard.are(GuardAction.CHANGED, GuardAction.FAIL_SAFE)
        refute("a guard's cause without its act, or an act without one", acts != cause)
        refute("an input that the guard changed, which it did not", (block.ragged("u_asked").counts > 0) & ~acts)
        if not self._has_guard:
            refute("a guard that the scenario does not have", ~guard.are("") | (block.numbers("guarded") > 0))
        runs = phase == PlantPhase.RUNNING
        since_ns = block.numbers("input_since_ns")
        late = since_ns != plant_ns if self._is_predicted else since_ns > plant_ns
        refute("phase RUNNING with an input of another time", runs & late)
        error = block.numbers("integration_error")
        refute("an integration error that the plant does not tolerate", error > LOCAL_TOLERANCE)
        refute(
            "an input in force that was never received",
            runs & (block.numbers("applied_tick") > block.numbers("received_tick")),
        )
        (law,) = np.nonzero(phase == PlantPhase.FAIL_SAFE)
        if law.size:
            expected = self._law()(block.matrix("x", self._n)[:, law])[0]
            asked = inputs_asked(block).matrix(self._m).T[:, law]
            numbers = block.sequence[law]
            difference = relative(asked, expected)
            at_s = plant_ns[law] / NS_PER_S
            name = "fail-safe law"
            self._agreement.compare(name, difference, at_s, ROUNDING, lambda row: f"state {int(numbers[row])}")

    def _take_changes(self, found: _Reports) -> None:
        """Check each state that follows another by that one."""
        of = {path: (column[:-1], column[1:]) for path, column in found.of.items()}
        before_ns, plant_ns = of["plant_ns"]
        follows = np.diff(found.sequence) == 1
        refute = self._refuter(found.sequence[1:], plant_ns)
        for path in _COUNTS:
            refute(f"{path} goes back", follows & (of[path][1] < of[path][0]))
        same = follows & (of["input_epoch"][0] == of["input_epoch"][1])
        for path in _OF_FILTER:
            refute(f"{path} goes back", same & (of[path][1] < of[path][0]))
        known = same & (of["received_tick"][0] == of["received_tick"][1])
        refute("input_lead_ns changes without another input", known & (np.diff(found.of["input_lead_ns"]) != 0))
        self._take_breaks(of, follows, refute)
        self._take_held(found, of, follows, refute)
        moved = follows & (plant_ns > before_ns)
        stopped = (of["stop"][1] != 0) & (of["phase"][1] != PlantPhase.FAIL_SAFE)
        refute("an input under an emergency stop", moved & stopped & (of["phase"][1] != PlantPhase.WAITING))
        periods = np.maximum((plant_ns - before_ns) // self._period_ns, 0)
        more = np.diff(found.of["guarded"])
        refute("guarded more often than there were inputs", follows & (more > periods + (before_ns == 0)))
        once = moved & (periods == 1) & (before_ns > 0)
        refute("an act of the guard that it did not count, or a count of none", once & ((more == 1) != found.acts[1:]))

    def _take_held(
        self,
        found: _Reports,
        of: dict[str, tuple[IntArray, IntArray]],
        follows: Rows,
        refute: Callable[[str, Rows], None],
    ) -> None:
        """Check that a held input is that of the state before, or of a period between that was not reported.

        A plant with a clock of its own reports the last of the periods that passed in a stall.
        """
        (before_ns, plant_ns), (_, since_ns) = of["plant_ns"], of["input_since_ns"]
        is_renewed = (since_ns > before_ns) & (since_ns < plant_ns)
        holds = follows & (of["phase"][1] == PlantPhase.HOLDING) & ~is_renewed
        for path in ("applied_tick", "input_since_ns"):
            refute(f"phase HOLDING with another {path}", holds & (of[path][0] != of[path][1]))
        changed = (found.asked[:, 1:] != found.asked[:, :-1]).any(axis=0)
        refute("phase HOLDING with another input", holds & changed)

    def _take_breaks(
        self, of: dict[str, tuple[IntArray, IntArray]], follows: Rows, refute: Callable[[str, Rows], None]
    ) -> None:
        """Check that sequences break when the input of the filter is missing, and at no other time."""
        (before_ns, plant_ns), (old_ns, break_ns) = of["plant_ns"], of["sequence_break_ns"]
        changes = follows & (break_ns != old_ns)
        refute("a sequence break of another time", changes & ((break_ns < before_ns) | (break_ns > plant_ns)))
        if self._is_predicted:
            phase, next_phase = of["phase"]
            ends = (phase == PlantPhase.RUNNING) & (next_phase != PlantPhase.RUNNING)
            refute("an input is missing without a sequence break", follows & ends & ~changes)

    def _refuter(self, sequence: IntArray, plant_ns: IntArray) -> Callable[[str, Rows], None]:
        at_s = plant_ns / NS_PER_S
        return lambda what, wrong: self._agreement.refute(what, wrong, at_s, lambda row: f"state {int(sequence[row])}")


def _fail_safe_law(scenario: Scenario) -> BatchFunction:
    """Return the law that the plant applies when inputs are missing, within its limits (``FailSafe``)."""
    robot = robot_of(scenario)
    limits = design_of(scenario, robot).limits
    centre, low, high = (ca.DM(list(each)) for each in (limits.centre, limits.low, limits.high))
    law = limits.clip(robot.fail_safe, centre, low, high)
    return BatchFunction(dense_function("fail_safe", [robot.system.x], [law]), by_casadi=True)
