"""Steering metrics: how well a robot followed its targets, from arrays of any source."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe_services.scenarios.source_schema import Target
from passafe_services.tools.review.plant_evaluator import FloatArray


class Leg(BaseModel):
    """Leg of a run: the time in which one target is active.

    Attributes:
        target: Position of the target, m or rad.
        at_s: Plant time at which the target becomes active, s.
        time_to_target_s: Settling time: from then until the robot stays within the tolerance to the end of the leg, s;
            ``None`` if it does not.
        overshoot: Largest distance beyond the target along the straight line to it; 0 without overshoot.
        rms_error: √(mean ‖p − target‖²) over the leg, approach included.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    target: tuple[float, ...]
    at_s: float
    time_to_target_s: float | None
    overshoot: float
    rms_error: float

    @classmethod
    def of(cls, target: Target, tolerance: float, t_s: FloatArray, position: FloatArray) -> Self:
        """Evaluate the samples of one leg, at least one.

        Args:
            target: The target.
            tolerance: Distance within which the target counts as reached.
            t_s: Plant time, s, shape (N,).
            position: Shape (k, N).
        """
        goal = np.array(target.position, dtype=np.float64)[:, None]
        distance = np.linalg.norm(position - goal, axis=0)
        (outside,) = np.nonzero(~(distance <= tolerance))  # a NaN is outside
        settled_from = int(outside[-1]) + 1 if outside.size else 0
        direction = goal - position[:, :1]
        length = float(np.linalg.norm(direction))
        beyond = (direction.T @ (position - goal)).ravel() / length if length > 0 else distance
        return cls(
            target=target.position,
            at_s=target.at_s,
            time_to_target_s=None if settled_from == len(t_s) else float(t_s[settled_from]) - target.at_s,
            overshoot=max(float(beyond.max()), 0.0),
            rms_error=_root_mean_square(t_s, distance),
        )


class Steering(BaseModel):
    """Steering metrics of a run.

    Attributes:
        legs: One leg for every target that became active.
        reached: Number of legs whose target was reached.
        overshoot: Largest overshoot of all legs.
        rms_error: √(mean ‖p − target‖²) from the first target on.
        effort: ∫‖u_h‖² dt, (units of u)²·s, of the request at the filter; ``None`` if unknown.
        held_back: ∫‖û − u‖² dt, (units of u)²·s: the part that the filter held back; ``None`` if unknown.
        collisions: Number of times that h fell below zero.
        collided_s: Total time with h below zero, s.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    legs: tuple[Leg, ...]
    reached: int
    overshoot: float
    rms_error: float
    effort: float | None
    held_back: float | None
    collisions: int
    collided_s: float

    @property
    def time_to_target_s(self) -> float | None:
        """Longest settling time of the legs, s; ``None`` if a target was not reached."""
        times = [leg.time_to_target_s for leg in self.legs]
        known = [time_s for time_s in times if time_s is not None]
        return max(known) if len(known) == len(times) else None

    @classmethod
    def of(
        cls,
        targets: Sequence[Target],
        tolerance: float,
        t_s: FloatArray,
        position: FloatArray,
        *,
        h: FloatArray | None = None,
        requested: tuple[FloatArray, FloatArray] | None = None,
        held_back: tuple[FloatArray, FloatArray] | None = None,
    ) -> Self | None:
        """Return the metrics of a run; ``None`` if it ended before its first target.

        Args:
            targets: In the order of their times.
            tolerance: Distance within which a target counts as reached.
            t_s: Plant time of the samples, s, increasing, shape (N,).
            position: Shape (k, N).
            h: Barrier values at the samples, shape (barriers, N).
            requested: Plant times, shape (M,), and u_h from each until the next, shape (m, M).
            held_back: Plant times, shape (M,), and û − u from each until the next, shape (m, M).
        """
        ends_s = [target.at_s for target in targets[1:]] + [np.inf]
        legs = []
        for target, end_s in zip(targets, ends_s, strict=True):
            during = (t_s >= target.at_s) & (t_s < end_s)
            if during.any():
                legs.append((Leg.of(target, tolerance, t_s[during], position[:, during]), during))
        if not legs:
            return None
        distances = [
            np.linalg.norm(position[:, during] - np.array(leg.target)[:, None], axis=0) for leg, during in legs
        ]
        collisions, collided_s = (0, 0.0) if h is None or not h.size else _collisions(t_s, h.min(axis=0))
        return cls(
            legs=tuple(leg for leg, _ in legs),
            reached=sum(leg.time_to_target_s is not None for leg, _ in legs),
            overshoot=max(leg.overshoot for leg, _ in legs),
            rms_error=_root_mean_square(np.concatenate([t_s[during] for _, during in legs]), np.concatenate(distances)),
            effort=None if requested is None else _energy(*requested),
            held_back=None if held_back is None else _energy(*held_back),
            collisions=collisions,
            collided_s=collided_s,
        )


def _root_mean_square(t_s: FloatArray, values: FloatArray) -> float:
    """Return √(mean of values²) over time by the trapezoidal rule; |value| for one sample."""
    duration_s = float(t_s[-1] - t_s[0])
    if duration_s <= 0:
        return float(abs(values[0]))
    return float(np.sqrt(np.trapezoid(values**2, t_s) / duration_s))


def _energy(t_s: FloatArray, values: FloatArray) -> float:
    """Return ∫‖values‖² dt of values held from each time until the next."""
    return float(((values[:, :-1] ** 2).sum(axis=0) * np.diff(t_s)).sum())


def _collisions(t_s: FloatArray, h: FloatArray) -> tuple[int, float]:
    """Return the number of times that h fell below zero, and the total time below zero, s."""
    inside = ~(h >= 0)  # a NaN is no safety
    entered = inside & ~np.concatenate([[False], inside[:-1]])
    return int(entered.sum()), float(np.diff(t_s)[inside[:-1]].sum())
