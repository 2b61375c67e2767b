"""Hold the signals of a whole run as arrays, for pictures."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import FilterStatus, FilterTick
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.tools.review.plant_evaluator import PlantEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S
from passafe_services.tools.review.verdict import trajectory_of

from passafe_dashboard.errors import SeriesError

FloatArray: TypeAlias = NDArray[np.float64]

PLANE_DIMENSIONS: Final = 2
MOST_BARRIERS: Final = 8
"""Barriers that a chart of a run shows; of more, those that stayed high are left out."""


class StatusSpan(NamedTuple):
    """A stretch of plant time in which every filter tick had the same status."""

    status: FilterStatus
    start_s: float
    end_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class RunSeries:
    """Signals of one run, one column a sample.

    Attributes:
        times_s: Plant time, s, shape (N,), N ≥ 1.
        x: State, shape (n, N), n ≥ 2; it begins with the position of each point in the plane, m.
        u: Input in force, shape (m, N).
        h: Barrier values at x, shape (barriers, N).
        power_margin_w: Power margin h_u(x, u), W, shape (N,).
        barriers: Every barrier, in the order of ``h``.
        statuses: Status of the filter, in order of time.
        points: Number of points in the plane; 0 for joints.
        places: Position of each point, m, shape (2·points, N); ``None``: with which the state begins.
    """

    times_s: FloatArray
    x: FloatArray
    u: FloatArray
    h: FloatArray
    power_margin_w: FloatArray
    barriers: tuple[SingleBarrier, ...]
    statuses: tuple[StatusSpan, ...]
    points: int = 1
    places: FloatArray | None = None

    def __post_init__(self) -> None:
        """Check that the arrays fit together."""
        samples = self.times_s.size
        states = self.x.shape[0] if self.x.ndim else 0
        inputs = self.u.shape[0] if self.u.ndim else 0
        _require("times_s", self.times_s, (samples,), "one dimension")
        _require("x", self.x, (states, samples), "a row for each state")
        _require("u", self.u, (inputs, samples), "a row for each input")
        _require("h", self.h, (len(self.barriers), samples), "a row for each barrier")
        _require("power_margin_w", self.power_margin_w, (samples,), "one dimension")
        if not samples:
            raise SeriesError("times_s", "no samples", "at least one")
        least = max(1, self.points) * PLANE_DIMENSIONS
        if self.places is None and states < least:
            raise SeriesError("x", f"{states} rows", f"{least} or more: positions come first")

    @property
    def lowest_barriers(self) -> tuple[int, ...]:
        """Numbers of the barriers that a chart shows: all, or the ``MOST_BARRIERS`` lowest ones."""
        lowest = self.h.min(axis=1)
        return tuple(sorted(int(i) for i in np.argsort(lowest, kind="stable")[:MOST_BARRIERS]))

    def position(self, point: int) -> FloatArray:
        """Return the position in the plane of a point, counted from 0, m, shape (2, N)."""
        places = self.x if self.places is None else self.places
        return places[PLANE_DIMENSIONS * point : PLANE_DIMENSIONS * (point + 1)]


def series_of(log: RunLog, evaluator: PlantEvaluator) -> RunSeries:
    """Return the signals of a logged run; barriers and power margin are recomputed from the plant's states alone.

    Raises:
        SeriesError: The log has no state of the plant.
        MismatchedLogError: Its states have not as many numbers as the scenario's.
    """
    scenario = log.identity.scenario
    trajectory = trajectory_of(log)
    ticks = ((tick.body.effective_plant_ns / NS_PER_S, tick.body.status) for tick in log.of(FilterTick))
    drawn = None if scenario.plant.robot is None else DrawnPlaces.of(robot_of(scenario))
    points = scenario.plant.robot_model.points if drawn is None else drawn.count
    return RunSeries(
        times_s=trajectory.t_s,
        x=trajectory.x,
        u=trajectory.u,
        h=evaluator.h(trajectory.x, trajectory.t_s),
        power_margin_w=evaluator.power_margin(trajectory.x, trajectory.u),
        barriers=scenario.barriers,
        statuses=status_spans(ticks, period_s=scenario.dt_s),
        points=points,
        places=None if drawn is None else drawn.many(trajectory.x)[: PLANE_DIMENSIONS * points],
    )


def _require(field: str, array: FloatArray, shape: tuple[int, ...], rows: str) -> None:
    if array.shape != shape:
        raise SeriesError(field, f"shape {array.shape}", f"{shape}: {rows}, a column for each sample")


def status_spans(ticks: Iterable[tuple[float, FilterStatus]], *, period_s: float) -> tuple[StatusSpan, ...]:
    """Join ticks of equal status that follow each other.

    Args:
        ticks: Plant time, s, and status of each tick, in order of time.
        period_s: How long the last tick of a span lasts; a longer wait until the next tick leaves a hole.
    """
    spans: list[StatusSpan] = []
    for time_s, status in ticks:
        if spans:
            last = spans[-1]
            joined = time_s - last.end_s <= period_s / 2
            if joined and status is last.status:
                spans[-1] = last._replace(end_s=time_s + period_s)
                continue
        spans.append(StatusSpan(status, time_s, time_s + period_s))
    return tuple(spans)
