"""Trajectory of the plant as arrays: states, inputs in force, and states between samples."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
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
            x=_columns([state.x for state in bodies]),
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
