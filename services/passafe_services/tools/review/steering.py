"""How well a robot was steered to its targets: from a trajectory's arrays, whatever they come from."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe_services.scenarios.source_schema import Target
from passafe_services.tools.review.plant_evaluator import FloatArray


class Leg(BaseModel):
    """The way to one target, from the moment it holds until the next one does.

    Attributes:
        target: Its position, m or rad.
        at_s: Plant time from which it holds, s.
        time_to_target_s: How long after that the robot was there to stay: within the tolerance at every sample until
            the leg ended; ``None`` if it was not at the end.
        overshoot: How far the robot went beyond the target along the straight way to it at most; 0 if it did not.
        rms_error: √(mean ‖p − target‖²) over the leg, that of the way there included.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    target: tuple[float, ...]
    at_s: float
    time_to_target_s: float | None
    overshoot: float
    rms_error: float

    @classmethod
    def of(cls, target: Target, tolerance: float, t_s: FloatArray, position: FloatArray) -> Self:
        """Score the samples of one leg, at least one.

        Args:
            target: The target.
            tolerance: Distance within which it counts as reached.
            t_s: Plant time, s, shape (N,).
            position: Shape (k, N).
        """
        goal = np.array(target.position, dtype=np.float64)[:, None]
        distance = np.linalg.norm(position - goal, axis=0)
        (outside,) = np.nonzero(~(distance <= tolerance))  # a NaN is outside
        stays_from = int(outside[-1]) + 1 if outside.size else 0
        way = goal - position[:, :1]
        length = float(np.linalg.norm(way))
        beyond = (way.T @ (position - goal)).ravel() / length if length > 0 else distance
        return cls(
            target=target.position,
            at_s=target.at_s,
            time_to_target_s=None if stays_from == len(t_s) else float(t_s[stays_from]) - target.at_s,
            overshoot=max(float(beyond.max()), 0.0),
            rms_error=_root_mean_square(t_s, distance),
        )


class Steering(BaseModel):
    """Scores of a whole run.

    Attributes:
        legs: One for every target whose time came.
        reached: Legs whose target was reached to stay.
        overshoot: Largest of all legs.
        rms_error: √(mean ‖p − target‖²) from the first target on.
        effort: ∫‖u_h‖² dt, (units of u)²·s, of what the filter read of the commands; ``None`` if that is not known.
        held_back: ∫‖u_h − passed‖² dt, the same unit: what did not become motion; ``None`` if that is not known.
        collisions: How often h fell below zero.
        collided_s: How long it was there, s.
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
        """The longest time that one of the legs took, s; ``None`` if a target was not reached."""
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
        asked: tuple[FloatArray, FloatArray] | None = None,
        withheld: tuple[FloatArray, FloatArray] | None = None,
    ) -> Self | None:
        """Score a run; ``None`` if it ended before its first target's time.

        Args:
            targets: In the order of their times.
            tolerance: Distance within which a target counts as reached.
            t_s: Plant time of the samples, s, increasing, shape (N,).
            position: Shape (k, N).
            h: Barrier values at the samples, shape (barriers, N).
            asked: Plant times, shape (M,), and u_h from each until the next, shape (m, M).
            withheld: The same with u_h − what passed, which is û − u.
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
            effort=None if asked is None else _energy(*asked),
            held_back=None if withheld is None else _energy(*withheld),
            collisions=collisions,
            collided_s=collided_s,
        )


def _root_mean_square(t_s: FloatArray, values: FloatArray) -> float:
    """√(mean of values²) over time by the trapezoidal rule; the value itself for one sample."""
    duration_s = float(t_s[-1] - t_s[0])
    if duration_s <= 0:
        return float(abs(values[0]))
    return float(np.sqrt(np.trapezoid(values**2, t_s) / duration_s))


def _energy(t_s: FloatArray, values: FloatArray) -> float:
    """∫‖values‖² dt of what is held from each time until the next."""
    return float(((values[:, :-1] ** 2).sum(axis=0) * np.diff(t_s)).sum())


def _collisions(t_s: FloatArray, h: FloatArray) -> tuple[int, float]:
    """How often the smallest barrier value fell below zero, and how long it was there, s."""
    inside = ~(h >= 0)  # a NaN is no safety
    entered = inside & ~np.concatenate([[False], inside[:-1]])
    return int(entered.sum()), float(np.diff(t_s)[inside[:-1]].sum())
