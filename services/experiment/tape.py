"""What is kept of a loop in virtual time: no message more than its figures need, none decoded, no telemetry made."""

from collections.abc import Mapping
from struct import Struct
from typing import Final

import numpy as np

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from protocol.messages import PlantInput, PlantPhase, PlantState
from protocol.topics import INPUT, STATE, TICK, Topic
from services.filter.telemetry import TickRecord
from services.review.evidence import Answers, Inputs, IntArray
from services.review.steering_of_log import Requests
from services.review.trajectory import Trajectory
from services.runtime.lockstep import Tap

_UNCERTIFIED: Final = Status.UNCERTIFIED

_Answer = tuple[int, int, int, int, Status, tuple[float, ...]]


class Tape:
    """Taps of a loop, and what came out of them as arrays.

    A tick costs three appends and a tuple, about a microsecond; what is made of them is made once, at the end.

    Attributes:
        taps: For ``Lockstep``.
    """

    def __init__(self, core: SafetyPassivityFilter, *, steered: bool = False) -> None:
        """Start empty.

        Args:
            core: The filter of the loop.
            steered: Whether to keep what the filter is asked for, too: for the scores of who steers.
        """
        self._states: list[PlantState] = []
        self._sent: list[PlantInput] = []
        self._answered: list[_Answer] = []
        self._residuals = Struct("3d").unpack_from, core.layout.parts["residuals"].start * 8
        self.taps: Mapping[Topic, Tap] = {STATE: self._states.append, INPUT: self._sent.append, TICK: self._answer}
        self._asked: list[tuple[int, Decision]] = []
        if steered:
            self.taps = {**self.taps, TICK: self._ask_and_answer}

    def forget_beyond(self, plant_ns: int) -> None:
        """Forget ticks and inputs for later plant times: how many there are is a matter of who stops first."""
        self._sent[:] = [sent for sent in self._sent if sent.effective_plant_ns <= plant_ns]
        self._answered[:] = [answer for answer in self._answered if answer[1] <= plant_ns]
        self._asked[:] = [asked for asked in self._asked if asked[0] <= plant_ns]

    @property
    def plant_ns(self) -> int:
        """Plant time so far, ns."""
        return self._states[-1].plant_ns if self._states else 0

    @property
    def inputs_late(self) -> int:
        """Inputs that reached the plant after their time."""
        return self._states[-1].inputs_late if self._states else 0

    @property
    def inputs_refused(self) -> int:
        """Inputs that the plant refused."""
        return self._states[-1].inputs_refused if self._states else 0

    def trajectory(self) -> Trajectory:
        """Motion of the plant."""
        return Trajectory.unbroken(self._moving())

    def phases(self) -> IntArray:
        """Phase of the plant at every sample of the trajectory, shape (N,)."""
        return np.fromiter((state.phase for state in self._moving()), dtype=np.int64)

    def input_slack_ns(self) -> IntArray:
        """By how much the newest input came before its time, at every sample of the trajectory, ns, shape (N,)."""
        return np.array([state.input_slack_ns for state in self._moving()], dtype=np.int64)

    def inputs(self) -> Inputs:
        """Inputs that the filter sent."""
        return Inputs.of(self._sent)

    def answers(self) -> Answers:
        """Ticks of the filter."""
        if not self._answered:
            return Answers.of(())
        claimed, at_ns, state_age_ns, command_age_ns, decided, residuals = zip(*self._answered, strict=True)
        accepted = np.array([status is not _UNCERTIFIED for status in decided])
        return Answers(
            status=np.fromiter(claimed, dtype=np.int64),
            residual=np.where(accepted, np.max(residuals, axis=1), np.inf),
            at_ns=np.fromiter(at_ns, dtype=np.int64),
            command_age_ns=np.fromiter(command_age_ns, dtype=np.int64),
            state_age_ns=np.fromiter(state_age_ns, dtype=np.int64),
        )

    def requests(self) -> Requests | None:
        """What the filter was asked for and what it withheld; ``None`` where that was not kept."""
        return Requests.of(
            (at_ns, tuple(decision.part("u_h").tolist()), tuple(decision.u_nominal.tolist()), decision.u)
            for at_ns, decision in self._asked
        )

    def _moving(self) -> list[PlantState]:
        return [state for state in self._states if state.phase is not PlantPhase.WAITING]

    def _answer(self, record: TickRecord) -> None:
        decision = record.decision
        unpack, at = self._residuals
        self._answered.append(
            (
                record.status,
                record.effective_plant_ns,
                record.state_age_ns,
                record.command_age_ns,
                decision.status,
                unpack(decision.block, at),  # type: ignore[arg-type] # an array is a buffer, half as dear as its view
            )
        )

    def _ask_and_answer(self, record: TickRecord) -> None:
        self._asked.append((record.effective_plant_ns, record.decision))
        self._answer(record)
