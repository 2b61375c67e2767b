"""Record of the plant of a run, from its states as they come: motion, sequence breaks, stops, sessions."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantPhase
from passafe_protocol.topics import HEALTH, STATE

from passafe_services.log.actual_states import actual_states
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.between_samples import MarginsInProgress
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.emergency_stops import StopRecord, StopStretch
from passafe_services.tools.review.errors import MismatchedLogError
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.sequence_breaks import BreakRecord
from passafe_services.tools.review.sole_plant import PlantRecord
from passafe_services.tools.review.state_check import StateCheck
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory

PLANT: Final = "plant"
"""Source of the plant's messages."""

MOST_TIMES: Final = 1 << 16
"""Pairs of wall time and plant time that are kept of a session: all of a minute's at 1 kHz, every 64th of an hour's."""


class TimesKept:
    """Wall times and plant times of a session, thinned out as they become many."""

    def __init__(self) -> None:
        self._pairs: IntArray = np.zeros((2, 0), dtype=np.int64)
        self._step = 1
        self._seen = 0

    def add(self, wall_ns: IntArray, plant_ns: IntArray) -> None:
        """Add states in order."""
        kept = slice(-self._seen % self._step, None, self._step)
        self._seen += wall_ns.size
        self._pairs = np.concatenate((self._pairs, np.stack((wall_ns[kept], plant_ns[kept]))), axis=1)
        while self._pairs.shape[1] > MOST_TIMES:
            self._pairs = self._pairs[:, ::2].copy()
            self._step *= 2

    def plant_s(self, wall_ns: int) -> float | None:
        """Return the plant time of the last state up to a wall time, s; ``None`` if all came later."""
        (before,) = np.nonzero(self._pairs[0] <= wall_ns)
        return float(self._pairs[1, before[-1]] / NS_PER_S) if before.size else None


@dataclass(kw_only=True, eq=False)
class PlantSession:
    """One session of the plant.

    Attributes:
        number: Its number, in the order in which the log met them.
        breaks: Its sequence breaks.
        stops: Its emergency stops.
        waited: Whether its first state was before the first input.
        first_ns: Plant time of its first state with the first input behind it, ns; ``None`` without one.
        last_ns: Plant time of its last state, ns.
        last_x: That state, shape (n,).
        held: Its newest state, which comes again as the first of the next piece.
        is_read: Whether its states are as they were read; the plant does not know the true ones.
    """

    number: int
    breaks: BreakRecord = field(default_factory=BreakRecord)
    stops: StopRecord = field(default_factory=StopRecord)
    waited: bool = False
    first_ns: int | None = None
    last_ns: int = 0
    last_x: FloatArray | None = None
    held: tuple[Trajectory, int] | None = None
    is_started: bool = False
    is_read: bool = False
    times: TimesKept = field(default_factory=TimesKept)


class PlantReview:
    """Record of the plant of a run.

    Args:
        path: The log, for errors.
        n: Numbers of a state.
        m: Numbers of an input.
        period_s: Period of the plant, s.
        margins: Takes the motion.
        drive: Takes the phases.
        check: Takes states and motion.

    Attributes:
        sessions: Sessions of the plant, by source and epoch, in the order in which the log met them.
        plants: When each was there.
    """

    wants: ClassVar[Wants] = {
        STATE.name: (
            *("plant_ns", "x", "true_x", "y", "u", "phase", "energy_in_j", "energy_stored_j", "stop", "stop_source"),
            *("header.sent_ns", "header.clock_id"),
        ),
        HEALTH.name: ("header.sent_ns",),
    }

    def __init__(
        self,
        path: Path,
        n: int,
        m: int,
        period_s: float,
        margins: MarginsInProgress,
        drive: DriveRecord,
        check: StateCheck,
    ) -> None:
        self._path = path
        self._n, self._m, self._period_s = n, m, period_s
        self._margins = margins
        self._drive = drive
        self._check = check
        self.sessions: dict[tuple[str, int], PlantSession] = {}
        self.plants = PlantRecord()

    def take(self, part: LogSlice) -> None:
        """Take the next states."""
        for block in part.blocks(STATE.name):
            self._take(block)
        for block in part.blocks(HEALTH.name):
            if block.source == PLANT:
                self._drive.add_health(int(block.numbers("header.sent_ns")[-1]), session=block.epoch)

    def finish(self) -> None:
        """Account for the last state of each session."""
        for session in self.sessions.values():
            if session.held is not None:
                is_start, is_read = not session.is_started, session.is_read
                self._margins.take(session.held[0], is_start=is_start, has_next=False, is_read=is_read)
                session.held = None

    @property
    def moving(self) -> Sequence[PlantSession]:
        """Sessions that had an input, in the order in which the log met them."""
        in_order = sorted(self.sessions.items(), key=lambda item: (item[0][0], item[1].number))
        return [session for _, session in in_order if session.first_ns is not None]

    @property
    def duration_s(self) -> float:
        """Plant time covered, s: sessions one after the other add up; of two at once, the longer one counts."""
        total_s = longest_s = 0.0
        end_ns: int | None = None
        spans = self.plants.spans
        lasted = {
            spans[epoch]: (session.last_ns - session.first_ns) / NS_PER_S
            for (_, epoch), session in self.sessions.items()
            if session.first_ns is not None
        }
        for (first_ns, last_ns), lasted_s in sorted(lasted.items()):
            if end_ns is not None and first_ns < end_ns:
                longest_s, end_ns = max(longest_s, lasted_s), max(end_ns, last_ns)
            else:
                total_s, longest_s, end_ns = total_s + longest_s, lasted_s, last_ns
        return total_s + longest_s

    @property
    def final_x(self) -> tuple[float, ...] | None:
        """Last state of the last session that had an input."""
        moving = self.moving
        last = moving[-1].last_x if moving else None
        return None if last is None else tuple(last.tolist())

    @property
    def stops(self) -> list[StopStretch]:
        """Emergency stops of all sessions."""
        return [stop for session in self.sessions.values() for stop in session.stops.stretches()]

    def plant_s(self, wall_ns: int) -> float | None:
        """Return the plant time of the last state up to a wall time, s."""
        found = None
        for session in self.sessions.values():
            at_s = session.times.plant_s(wall_ns)
            found = found if at_s is None else at_s
        return found

    def _take(self, block: MessageBlock) -> None:
        key = (block.source, block.epoch)
        session = self.sessions.get(key)
        plant_ns, phase = block.numbers("plant_ns"), block.numbers("phase")
        if session is None:
            self.sessions[key] = session = PlantSession(number=block.session)
            session.waited = bool(phase[0] == PlantPhase.WAITING)
        wall_ns, sent_ns = block.numbers("header.wall_ns"), block.numbers("header.sent_ns")
        for clock_id in np.unique(block.numbers("header.clock_id")).tolist():
            self.plants.add(block.epoch, clock_id, sent_ns, wall_ns)
        session.times.add(wall_ns, plant_ns)
        session.breaks.add(plant_ns, wall_ns, phase)
        session.stops.add_all(plant_ns, block.numbers("stop") != 0, block.texts("stop_source"))
        moves = phase != PlantPhase.WAITING
        runs = phase == PlantPhase.RUNNING
        self._drive.add_states(
            plant_ns[moves],
            runs[moves],
            session=block.epoch,
            wall_ns=int(wall_ns[-1]),
            sent_ns=int(sent_ns[-1]),
        )
        x, u = self._vectors(block, "x", self._n), self._vectors(block, "u", self._m)
        self._check.take_states(block, x)
        x = actual_states(block, self._n)
        if not moves.any():
            return
        if session.first_ns is None:
            session.first_ns = int(plant_ns[moves][0])
        session.last_ns, session.last_x = int(plant_ns[moves][-1]), x[:, moves][:, -1]
        piece = self._piece(session, block, moves, x, u)
        session.is_read = bool((block.ragged("true_x").counts[moves] != self._n).all())
        is_start, is_read = not session.is_started, session.is_read
        self._margins.take(piece, is_start=is_start, has_next=True, is_read=is_read)
        self._check.take_motion(piece)
        session.is_started = session.is_started or piece.samples > 1
        # A single sample is taken again with what follows it.
        session.held = piece.last(), int(block.sequence[moves][-1])

    def _piece(
        self, session: PlantSession, block: MessageBlock, moves: NDArray[np.bool_], x: FloatArray, u: FloatArray
    ) -> Trajectory:
        """Return the trajectory of states that move, the held one before them."""
        sequence = block.sequence[moves]
        plant_ns = block.numbers("plant_ns")[moves]
        follows = np.diff(sequence, append=sequence[-1:]) == 1
        piece = Trajectory(
            t_s=np.asarray(plant_ns / NS_PER_S, dtype=np.float64),
            x=x[:, moves],
            u=u[:, moves],
            runs=block.numbers("phase")[moves] == PlantPhase.RUNNING,
            energy_in_j=block.numbers("energy_in_j")[moves],
            energy_stored_j=block.numbers("energy_stored_j")[moves],
            session=np.full(plant_ns.size, session.number, dtype=np.int64),
            period_s=np.where(follows, self._lasted_s(np.diff(plant_ns, append=plant_ns[-1:])), 0.0),
        )
        if session.held is None:
            return piece
        held, number = session.held
        gap_ns = plant_ns[:1] - np.rint(held.t_s * NS_PER_S)
        return held.followed_by(piece, float(self._lasted_s(gap_ns)[0]) if int(sequence[0]) == number + 1 else 0.0)

    def _lasted_s(self, lasted_ns: NDArray[Any]) -> FloatArray:
        """Return durations: the plant moves by its period, which its clock rounds to a nanosecond."""
        is_period = np.abs(lasted_ns - self._period_s * NS_PER_S) < 1.0
        return np.where(is_period, self._period_s, lasted_ns / NS_PER_S)

    def _vectors(self, block: MessageBlock, path: str, allowed: int) -> FloatArray:
        column = block.ragged(path)
        (wrong,) = np.nonzero(column.counts != allowed)
        if wrong.size:
            row = wrong[0]
            where = f"state {int(block.sequence[row])}"
            got = f"{int(column.counts[row])} numbers, allowed {allowed} as in the scenario"
            raise MismatchedLogError(self._path, f"{where}: got {got}")
        found: FloatArray = column.matrix(allowed).T
        return found
