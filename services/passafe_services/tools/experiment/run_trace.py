"""The trace of a run in virtual time: of every message the numbers that its metrics need."""

from collections.abc import Iterator, Mapping
from math import prod
from struct import Struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantInput, PlantPhase, PlantState
from passafe_protocol.topics import INPUT, STATE, TICK, Topic

from passafe.decision import CERTIFIED, Decision
from passafe.filter import SafetyPassivityFilter
from passafe_services.filter.telemetry import TickRecord
from passafe_services.loop.lockstep import Tap
from passafe_services.tools.review.filter_claims import Decisions, IntArray, SentInputs
from passafe_services.tools.review.steering_of_log import Requests
from passafe_services.tools.review.trajectory import Trajectory

WAITING: Final = PlantPhase.WAITING


class _Rows:
    """Rows of numbers, all alike, packed one behind the other.

    Attributes:
        pack: Makes the bytes of one row from its integers and, after them, its other numbers.
        packed: The bytes of all; who has packed a row appends it.
    """

    def __init__(self, *integers: str, **numbers: tuple[int, ...]) -> None:
        """Start empty.

        Args:
            integers: Names of the columns of integers.
            numbers: Names of the others, with the shape of an entry.
        """
        count = sum(prod(shape) for shape in numbers.values())
        self.pack = Struct(f"={len(integers)}q{count}d").pack
        self.packed = bytearray()
        self._row = np.dtype(
            [(name, "i8") for name in integers] + [(name, "f8", shape) for name, shape in numbers.items()]
        )

    def all(self) -> NDArray[Any]:
        """Return every row, a structured array."""
        return np.frombuffer(self.packed, self._row)


class RunTrace:
    """Taps of a loop, and what they kept as arrays.

    Numbers are packed at once, one row a message: the memory of a message that is let go stays in cache for the next,
    and arrays are made of the rows once, at the end.

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
        n, m = (system.n,), (system.m,)
        self._states = _Rows("plant_ns", "phase", "lead_ns", energy_in_j=(), energy_stored_j=(), x=n, u=m)
        self._sent = _Rows("at_ns", "sequence_start_ns", u=m)
        self._answered = _Rows(
            "status", "at_ns", "state_age_ns", "command_age_ns", "decided", residuals=(3,), slack_w=()
        )
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

    @property
    def inputs_guarded(self) -> int:
        """Periods whose input the plant's guard has changed."""
        return 0 if self._newest is None else self._newest.guarded

    def trajectory(self) -> Trajectory:
        """Return the motion of the plant."""
        rows = self._states.all()
        return Trajectory.unbroken(
            plant_ns=np.array(rows["plant_ns"]),
            x=np.array(rows["x"]).T,
            u=np.array(rows["u"]).T,
            runs=rows["phase"] == PlantPhase.RUNNING,
            energy_in_j=np.array(rows["energy_in_j"]),
            energy_stored_j=np.array(rows["energy_stored_j"]),
        )

    def phases(self) -> IntArray:
        """Return the phase of the plant at every sample of the trajectory, shape (N,)."""
        return np.array(self._states.all()["phase"])

    def running_states(self) -> Iterator[tuple[bool, int]]:
        """Return whether an input of the filter was in force, and plant time, ns, of every sample of the trajectory."""
        rows = self._states.all()
        return zip((rows["phase"] == PlantPhase.RUNNING).tolist(), rows["plant_ns"].tolist(), strict=True)

    def input_lead_ns(self) -> IntArray:
        """Return how long before its effect the newest input came, at every sample, ns, shape (N,)."""
        return np.array(self._states.all()["lead_ns"])

    def inputs(self) -> SentInputs:
        """Return the inputs that the filter sent."""
        rows = self._up_to_the_end(self._sent)
        starts = np.array(rows["sequence_start_ns"])
        return SentInputs(u=np.array(rows["u"]).T, at_ns=np.array(rows["at_ns"]), sequence_start_ns=starts)

    def answers(self) -> Decisions:
        """Return the ticks of the filter."""
        rows = self._up_to_the_end(self._answered)
        accepted = np.isin(rows["decided"], CERTIFIED)
        return Decisions(
            status=np.array(rows["status"]),
            residual=np.where(accepted, rows["residuals"].max(axis=1), np.inf),
            at_ns=np.array(rows["at_ns"]),
            slack_w=np.array(rows["slack_w"]),
            command_age_ns=np.array(rows["command_age_ns"]),
            state_age_ns=np.array(rows["state_age_ns"]),
        )

    def requests(self) -> Requests | None:
        """Return the requests and what the filter held back; ``None`` if they were not kept."""
        return Requests.of(
            (at_ns, tuple(decision.part("u_h").tolist()), tuple(decision.u_nominal.tolist()), decision.u)
            for at_ns, decision in self._asked
        )

    def _up_to_the_end(self, kept: _Rows) -> NDArray[Any]:
        rows = kept.all()
        return rows if self._until_ns is None else rows[rows["at_ns"] <= self._until_ns]

    def _keep_state(self, state: PlantState) -> None:
        self._newest = state
        if state.phase is not WAITING:
            self._states.packed += self._states.pack(
                state.plant_ns,
                state.phase,
                state.input_lead_ns,
                state.energy_in_j,
                state.energy_stored_j,
                *state.actual_x,
                *state.u,
            )

    def _keep_input(self, sent: PlantInput) -> None:
        self._sent.packed += self._sent.pack(sent.effective_plant_ns, sent.input_sequence_start_ns, *sent.u)

    def _answer(self, record: TickRecord) -> None:
        decision = record.decision
        assessment = decision.assessment
        self._answered.packed += self._answered.pack(
            record.status,
            record.effective_plant_ns,
            record.state_age_ns,
            record.request.age_ns,
            decision.status,
            assessment.primal,
            assessment.dual,
            assessment.gap,
            assessment.slack,
        )

    def _ask_and_answer(self, record: TickRecord) -> None:
        self._asked.append((record.effective_plant_ns, record.decision))
        self._answer(record)
