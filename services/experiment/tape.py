"""What is kept of a loop in virtual time: of every message the numbers that its figures need, and no message."""

from collections.abc import Mapping
from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from protocol.messages import PlantInput, PlantPhase, PlantState
from protocol.topics import INPUT, STATE, TICK, Topic
from services.filter.telemetry import TickRecord
from services.review.evidence import Answers, Inputs, IntArray
from services.review.steering_of_log import Requests
from services.review.trajectory import Trajectory
from services.runtime.lockstep import Tap

WAITING: Final = PlantPhase.WAITING

_INTEGER: Final = "i8"
_NUMBER: Final = "f8"


class Tape:
    """Taps of a loop, and what came out of them as arrays.

    Numbers are packed at once, one row a message: a message that is let go is memory that the next one finds warm, and
    what is made of the rows is made once, at the end.

    Attributes:
        taps: For ``Lockstep``.
    """

    def __init__(self, core: SafetyPassivityFilter, *, steered: bool = False) -> None:
        """Start empty.

        Args:
            core: The filter of the loop.
            steered: Whether to keep what the filter is asked for, too: for the scores of who steers.
        """
        system = core.design.system
        self._newest: PlantState | None = None
        self._until_ns: int | None = None
        self._states, self._sent, self._answered = bytearray(), bytearray(), bytearray()
        self._pack_state = Struct(f"=3q{2 + system.n + system.m}d").pack
        self._state_row = np.dtype(
            [
                ("plant_ns", _INTEGER),
                ("phase", _INTEGER),
                ("slack_ns", _INTEGER),
                ("energy_in_j", _NUMBER),
                ("energy_stored_j", _NUMBER),
                ("x", _NUMBER, (system.n,)),
                ("u", _NUMBER, (system.m,)),
            ]
        )
        self._pack_input = Struct(f"=q{system.m}d").pack
        self._input_row = np.dtype([("at_ns", _INTEGER), ("u", _NUMBER, (system.m,))])
        self._pack_answer = Struct("=5q3d").pack
        self._answer_row = np.dtype(
            [
                ("status", _INTEGER),
                ("at_ns", _INTEGER),
                ("state_age_ns", _INTEGER),
                ("command_age_ns", _INTEGER),
                ("decided", _INTEGER),
                ("residuals", _NUMBER, (3,)),
            ]
        )
        self._residuals = Struct("3d").unpack_from, core.layout.parts["residuals"].start * 8
        self.taps: Mapping[Topic, Tap] = {STATE: self._keep_state, INPUT: self._keep_input, TICK: self._answer}
        self._asked: list[tuple[int, Decision]] = []
        if steered:
            self.taps = {**self.taps, TICK: self._ask_and_answer}

    def forget_beyond(self, plant_ns: int) -> None:
        """Forget ticks and inputs for later plant times: how many there are is a matter of who stops first."""
        self._until_ns = plant_ns
        self._asked[:] = [asked for asked in self._asked if asked[0] <= plant_ns]

    @property
    def plant_ns(self) -> int:
        """Plant time so far, ns."""
        return 0 if self._newest is None else self._newest.plant_ns

    @property
    def inputs_late(self) -> int:
        """Inputs that reached the plant after their time."""
        return 0 if self._newest is None else self._newest.inputs_late

    @property
    def inputs_refused(self) -> int:
        """Inputs that the plant refused."""
        return 0 if self._newest is None else self._newest.inputs_refused

    def trajectory(self) -> Trajectory:
        """Motion of the plant."""
        rows = self._moving()
        return Trajectory.unbroken(
            plant_ns=np.array(rows["plant_ns"]),
            x=np.array(rows["x"]).T,
            u=np.array(rows["u"]).T,
            energy_in_j=np.array(rows["energy_in_j"]),
            energy_stored_j=np.array(rows["energy_stored_j"]),
        )

    def phases(self) -> IntArray:
        """Phase of the plant at every sample of the trajectory, shape (N,)."""
        return np.array(self._moving()["phase"])

    def input_slack_ns(self) -> IntArray:
        """By how much the newest input came before its time, at every sample of the trajectory, ns, shape (N,)."""
        return np.array(self._moving()["slack_ns"])

    def inputs(self) -> Inputs:
        """Inputs that the filter sent."""
        rows = self._up_to_the_end(np.frombuffer(self._sent, self._input_row))
        return Inputs(largest=np.abs(rows["u"]).max(axis=1, initial=0.0), at_ns=np.array(rows["at_ns"]))

    def answers(self) -> Answers:
        """Ticks of the filter."""
        rows = self._up_to_the_end(np.frombuffer(self._answered, self._answer_row))
        accepted = rows["decided"] != Status.UNCERTIFIED
        return Answers(
            status=np.array(rows["status"]),
            residual=np.where(accepted, rows["residuals"].max(axis=1), np.inf),
            at_ns=np.array(rows["at_ns"]),
            command_age_ns=np.array(rows["command_age_ns"]),
            state_age_ns=np.array(rows["state_age_ns"]),
        )

    def requests(self) -> Requests | None:
        """What the filter was asked for and what it withheld; ``None`` where that was not kept."""
        return Requests.of(
            (at_ns, tuple(decision.part("u_h").tolist()), tuple(decision.u_nominal.tolist()), decision.u)
            for at_ns, decision in self._asked
        )

    def _moving(self) -> NDArray[Any]:
        return np.frombuffer(self._states, self._state_row)

    def _up_to_the_end(self, rows: NDArray[Any]) -> NDArray[Any]:
        return rows if self._until_ns is None else rows[rows["at_ns"] <= self._until_ns]

    def _keep_state(self, state: PlantState) -> None:
        self._newest = state
        if state.phase is not WAITING:
            self._states += self._pack_state(
                state.plant_ns,
                state.phase,
                state.input_slack_ns,
                state.energy_in_j,
                state.energy_stored_j,
                *state.x,
                *state.u,
            )

    def _keep_input(self, sent: PlantInput) -> None:
        self._sent += self._pack_input(sent.effective_plant_ns, *sent.u)

    def _answer(self, record: TickRecord) -> None:
        decision = record.decision
        unpack, at = self._residuals
        self._answered += self._pack_answer(
            record.status,
            record.effective_plant_ns,
            record.state_age_ns,
            record.command_age_ns,
            decision.status,
            *unpack(decision.block, at),  # type: ignore[arg-type] # an array is a buffer, half as dear as its view
        )

    def _ask_and_answer(self, record: TickRecord) -> None:
        self._asked.append((record.effective_plant_ns, record.decision))
        self._answer(record)
