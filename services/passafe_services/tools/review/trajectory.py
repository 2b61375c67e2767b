"""Trajectory of the plant as arrays: states, inputs in force, and states between samples."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantPhase, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator

NS_PER_S: Final = 1e9


class Instants(NamedTuple):
    """Instants between samples, one column per instant.

    Attributes:
        t_s: Plant time, s, shape (K,).
        x: State, shape (n, K).
        u: Input in force, shape (m, K).
        after_s: Time since the sample before, s.
    """

    t_s: FloatArray
    x: FloatArray
    u: FloatArray
    after_s: float


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Samples of the plant's motion, one column per sample; states before its first input are omitted.

    Attributes:
        t_s: Plant time, s, shape (N,).
        x: State, shape (n, N).
        u: Input in force from this sample until the next, shape (m, N).
        runs: Whether that is an input of the filter, in its time; shape (N,).
        energy_in_j: ∫ yᵀu dt since plant time 0, J, shape (N,).
        energy_stored_j: V(x), J, shape (N,).
        session: Number of the plant's session, shape (N,).
        period_s: Time until the next sample if that is in the log, else 0, s; shape (N,).
    """

    t_s: FloatArray
    x: FloatArray
    u: FloatArray
    runs: NDArray[np.bool_]
    energy_in_j: FloatArray
    energy_stored_j: FloatArray
    session: NDArray[np.int64]
    period_s: FloatArray

    @classmethod
    def of(cls, states: Sequence[LoggedMessage[PlantState]]) -> Self:
        """Return the trajectory of logged states, given by session and in order of sequence."""
        moving = [state for state in states if state.body.phase is not PlantPhase.WAITING]
        epochs = np.array([state.header.epoch for state in moving], dtype=np.uint64)
        sequences = np.array([state.header.sequence for state in moving], dtype=np.uint64)
        session = np.cumsum(np.diff(epochs, prepend=epochs[:1]) != 0)
        follows = (np.diff(session, append=-1) == 0) & (np.diff(sequences, append=np.zeros(1, dtype=np.uint64)) == 1)
        bodies = [state.body for state in moving]
        one = cls.unbroken(
            plant_ns=np.array([state.plant_ns for state in bodies], dtype=np.int64),
            x=_columns([state.actual_x for state in bodies]),
            u=_columns([state.u for state in bodies]),
            runs=np.array([state.phase is PlantPhase.RUNNING for state in bodies], dtype=np.bool_),
            energy_in_j=np.array([state.energy_in_j for state in bodies], dtype=np.float64),
            energy_stored_j=np.array([state.energy_stored_j for state in bodies], dtype=np.float64),
        )
        return replace(one, session=session, period_s=np.where(follows, one.period_s, 0.0))

    @classmethod
    def unbroken(
        cls,
        *,
        plant_ns: NDArray[np.int64],
        x: FloatArray,
        u: FloatArray,
        runs: NDArray[np.bool_],
        energy_in_j: FloatArray,
        energy_stored_j: FloatArray,
    ) -> Self:
        """Return the trajectory of one session without missing samples, from its first input on.

        Args:
            plant_ns: Plant time, ns, shape (N,).
            x: State, shape (n, N).
            u: Input in force from each sample until the next, shape (m, N).
            runs: Whether that is an input of the filter, in its time; shape (N,).
            energy_in_j: ∫ yᵀu dt since plant time 0, J, shape (N,).
            energy_stored_j: V(x), J, shape (N,).
        """
        return cls(
            t_s=np.asarray(plant_ns / NS_PER_S, dtype=np.float64),
            x=x,
            u=u,
            runs=runs,
            energy_in_j=energy_in_j,
            energy_stored_j=energy_stored_j,
            session=np.zeros(len(plant_ns), dtype=np.int64),
            period_s=np.diff(plant_ns, append=plant_ns[-1:]) / NS_PER_S,
        )

    def sessions(self) -> Iterator[Self]:
        """Yield the trajectory of each session of the plant."""
        begins = np.flatnonzero(np.diff(self.session, prepend=self.session[:1] - 1)).tolist()
        for begin, end in pairwise([*begins, self.samples]):
            of = slice(begin, end)
            yield replace(
                self,
                t_s=self.t_s[of],
                x=self.x[:, of],
                u=self.u[:, of],
                runs=self.runs[of],
                energy_in_j=self.energy_in_j[of],
                energy_stored_j=self.energy_stored_j[of],
                session=self.session[of],
                period_s=self.period_s[of],
            )

    def last(self) -> Self:
        """Return the last sample by itself."""
        return replace(
            self,
            t_s=self.t_s[-1:],
            x=self.x[:, -1:],
            u=self.u[:, -1:],
            runs=self.runs[-1:],
            energy_in_j=self.energy_in_j[-1:],
            energy_stored_j=self.energy_stored_j[-1:],
            session=self.session[-1:],
            period_s=np.zeros(1),
        )

    def followed_by(self, other: Self, period_s: float) -> Self:
        """Return this trajectory and another behind it.

        Args:
            other: Later samples of the same session.
            period_s: Time from the last sample to the first of the other, s; 0 if samples are missing between them.
        """
        return replace(
            self,
            t_s=np.concatenate((self.t_s, other.t_s)),
            x=np.concatenate((self.x, other.x), axis=1),
            u=np.concatenate((self.u, other.u), axis=1),
            runs=np.concatenate((self.runs, other.runs)),
            energy_in_j=np.concatenate((self.energy_in_j, other.energy_in_j)),
            energy_stored_j=np.concatenate((self.energy_stored_j, other.energy_stored_j)),
            session=np.concatenate((self.session, other.session)),
            period_s=np.concatenate((self.period_s[:-1], [period_s], other.period_s)),
        )

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.t_s)

    def between(self, evaluator: PlantEvaluator, points: int) -> Iterator[Instants]:
        """Yield the instants at j/points of every period, j = 1 … points.

        The last one of a period, j = points, is the limit from the left: the state of the next sample with the input
        of this one.
        """
        for period_s in np.unique(self.period_s[self.period_s > 0]):
            begun = self.period_s == period_s
            t_s, x, u = self.t_s[begun], self.x[:, begun], self.u[:, begun]
            for j in range(1, points + 1):
                offset_s = float(period_s) * j / points
                yield Instants(t_s + offset_s, evaluator.flow(x, u, offset_s), u, offset_s)

    def mismatch(self, evaluator: PlantEvaluator) -> tuple[FloatArray, FloatArray]:
        """Return the distance between each logged state and the model's prediction from the previous one.

        Returns:
            ‖x_{k+1} − flow(x_k, u_k)‖∞ / (1 + ‖x_{k+1}‖∞), shape (K,), and the plant times of x_{k+1}, s.
        """
        errors, times = [np.zeros(0)], [np.zeros(0)]
        for period_s in np.unique(self.period_s[self.period_s > 0]):
            (begun,) = np.nonzero(self.period_s == period_s)
            reached = self.x[:, begun + 1]
            expected = evaluator.flow(self.x[:, begun], self.u[:, begun], float(period_s))
            errors.append(np.abs(reached - expected).max(axis=0) / (1 + np.abs(reached).max(axis=0)))
            times.append(self.t_s[begun + 1])
        return np.concatenate(errors), np.concatenate(times)


def _columns(rows: Sequence[Sequence[float]]) -> FloatArray:
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1).T if rows else np.zeros((0, 0))
