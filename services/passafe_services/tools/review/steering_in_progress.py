"""Steering metrics of a run whose states and ticks come piece by piece."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from passafe_services.scenarios.source_schema import HumanSource, Target
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.steering import Leg, Steering
from passafe_services.tools.review.time_order import TimeOrder
from passafe_services.tools.review.trajectory import NS_PER_S


class _MeanSquare:
    """∫v² dt by the trapezoidal rule, over samples that come in order."""

    def __init__(self) -> None:
        self._integral = 0.0
        self._first: tuple[float, float] | None = None
        self._last = (0.0, 0.0)

    def add(self, t_s: FloatArray, values: FloatArray) -> None:
        if self._first is None:
            self._first = float(t_s[0]), float(values[0])
        else:
            t_s, values = np.append(self._last[0], t_s), np.append(self._last[1], values)
        self._integral += float(np.trapezoid(values**2, t_s))
        self._last = float(t_s[-1]), float(values[-1])

    @property
    def root(self) -> float:
        """√(mean of v²); |v| for one sample."""
        first_s, first = self._first or (0.0, 0.0)
        duration_s = self._last[0] - first_s
        return float(np.sqrt(self._integral / duration_s)) if duration_s > 0 else abs(first)


class _LegInProgress:
    def __init__(self, target: Target, tolerance: float, start: FloatArray) -> None:
        self._target = target
        self._tolerance = tolerance
        self._goal = np.array(target.position, dtype=np.float64)[:, None]
        self._direction = self._goal - start
        self._beyond = 0.0
        self._settled_s: float | None = None
        self._error = _MeanSquare()

    def add(self, t_s: FloatArray, position: FloatArray) -> FloatArray:
        """Add samples and return their distances from the target."""
        away = position - self._goal
        distance: FloatArray = np.linalg.norm(away, axis=0)
        (outside,) = np.nonzero(~(distance <= self._tolerance))  # a NaN is outside
        if outside.size:
            self._settled_s = float(t_s[outside[-1] + 1]) if outside[-1] + 1 < t_s.size else None
        elif self._settled_s is None:
            self._settled_s = float(t_s[0])
        length = float(np.linalg.norm(self._direction))
        beyond = (self._direction.T @ away).ravel() / length if length > 0 else distance
        self._beyond = max(self._beyond, float(beyond.max()))
        self._error.add(t_s, distance)
        return distance

    def result(self) -> Leg:
        settled_s = self._settled_s
        return Leg(
            target=self._target.position,
            at_s=self._target.at_s,
            time_to_target_s=None if settled_s is None else settled_s - self._target.at_s,
            overshoot=max(self._beyond, 0.0),
            rms_error=self._error.root,
        )


class SteeringInProgress:
    """Steering metrics of a run in which a simulated person steered; of several sessions, the last one counts.

    Args:
        person: The person.

    Attributes:
        axes: Coordinates of a position.
    """

    def __init__(self, person: HumanSource) -> None:
        self._person = person
        self.axes = len(person.targets[0].position)
        self._starts_s = np.array([target.at_s for target in person.targets])
        self._requests = _HeldIntegral()
        self.restart()

    def restart(self) -> None:
        """Begin anew: a session of the plant begins."""
        self._legs: dict[int, _LegInProgress] = {}
        self._error = _MeanSquare()
        self._inside: tuple[float, bool] | None = None
        self._collisions = 0
        self._collided_s = 0.0

    def take_states(self, t_s: FloatArray, position: FloatArray, h: FloatArray) -> None:
        """Take states in order: plant times, s, shape (N,), positions (k, N) and barrier values (barriers, N)."""
        with np.errstate(over="ignore", invalid="ignore"):  # the metrics of a diverged run may overflow
            leg_of = np.searchsorted(self._starts_s, t_s, side="right") - 1
            for number in np.unique(leg_of[leg_of >= 0]).tolist():
                during = leg_of == number
                if number not in self._legs:
                    start = position[:, during][:, :1]
                    target = self._person.targets[number]
                    self._legs[number] = _LegInProgress(target, self._person.tolerance_m, start)
                distance = self._legs[number].add(t_s[during], position[:, during])
                self._error.add(t_s[during], distance)
            if h.size:
                self._collide(t_s, ~(h.min(axis=0) >= 0))  # a NaN is no safety

    def take_ticks(self, at_ns: IntArray, requested: FloatArray, held_back: FloatArray) -> None:
        """Take ticks: plant times, ns, shape (K,), u_h and û − u from each until the next, shape (m, K)."""
        self._requests.take(at_ns, requested, held_back)

    def result(self) -> Steering | None:
        """Return the metrics; ``None`` before the first target."""
        if not self._legs:
            return None
        legs: Sequence[Leg] = [self._legs[number].result() for number in sorted(self._legs)]
        effort, held_back = self._requests.result()
        return Steering(
            legs=tuple(legs),
            reached=sum(leg.time_to_target_s is not None for leg in legs),
            overshoot=max(leg.overshoot for leg in legs),
            rms_error=self._error.root,
            effort=effort,
            held_back=held_back,
            collisions=self._collisions,
            collided_s=self._collided_s,
        )

    def _collide(self, t_s: FloatArray, inside: NDArray[np.bool_]) -> None:
        if self._inside is not None:
            t_s, inside = np.append(self._inside[0], t_s), np.append(self._inside[1], inside)
            entered = inside[1:] & ~inside[:-1]
        else:
            entered = inside & ~np.concatenate([[False], inside[:-1]])
        self._collisions += int(entered.sum())
        self._collided_s += float(np.diff(t_s)[inside[:-1]].sum())
        self._inside = float(t_s[-1]), bool(inside[-1])


class _HeldIntegral:
    """∫‖u_h‖² dt and ∫‖û − u‖² dt of values that each hold until the next."""

    def __init__(self) -> None:
        self._order = TimeOrder(2)
        self._integrals = np.zeros(2)
        self._last: tuple[float, FloatArray] | None = None

    def take(self, at_ns: IntArray, requested: FloatArray, held_back: FloatArray) -> None:
        known = at_ns >= 0
        squares = np.stack([(part[:, known] ** 2).sum(axis=0) for part in (requested, held_back)])
        self._add(*self._order.take(at_ns[known], squares))

    def result(self) -> tuple[float | None, float | None]:
        self._add(*self._order.finish())
        return (None, None) if self._last is None else (float(self._integrals[0]), float(self._integrals[1]))

    def _add(self, at_ns: IntArray, squares: FloatArray) -> None:
        if not at_ns.size:
            return
        at_s = at_ns / NS_PER_S
        if self._last is not None:
            at_s, squares = np.append(self._last[0], at_s), np.concatenate((self._last[1], squares), axis=1)
        self._integrals += (squares[:, :-1] * np.diff(at_s)).sum(axis=1)
        self._last = float(at_s[-1]), squares[:, -1:]
