"""A scenario's barriers one by one: a room is four walls, every coordinate has two limits, every point its own."""

from collections.abc import Iterator, Sequence
from typing import Final, Literal, TypeAlias

from passafe_services.scenarios.barrier_schema import (
    ApartBarrier,
    BarrierConfig,
    Chain,
    CoordinatesBarrier,
    DiskBarrier,
    EllipseBarrier,
    HalfPlaneBarrier,
    Name,
    RoomBarrier,
    SpeedBarrier,
)
from passafe_services.scenarios.fields import Config

POINTS: Final = {
    "damped-point": 1,
    "drag-point": 1,
    "lagged-point": 1,
    "saturating-point": 1,
    "two-points": 2,
    "joint-chain": 0,
}
"""How many points in the plane each model moves."""

WALLS: Final = (
    ("left", 0, 1.0),
    ("right", 0, -1.0),
    ("bottom", 1, 1.0),
    ("top", 1, -1.0),
)
"""Of a room: its name, the axis that it is across, and where its normal points on it."""


class CoordinateLimit(Config):
    """One side of the limits of one coordinate: h = q − bound, or bound − q where it is the upper one.

    Attributes:
        name: Of the barrier.
        of: What q is one coordinate of.
        index: Which one, from 0.
        bound: In the coordinate's unit.
        upper: Whether q stays below it.
        class_k: Of its chain.
    """

    name: Name
    of: Literal["position", "velocity"]
    index: int
    bound: float
    upper: bool
    class_k: Chain


PlaceBarrier: TypeAlias = DiskBarrier | EllipseBarrier | HalfPlaneBarrier
SingleBarrier: TypeAlias = PlaceBarrier | SpeedBarrier | ApartBarrier | CoordinateLimit


def single_barriers(barriers: Sequence[BarrierConfig], model: str) -> tuple[SingleBarrier, ...]:
    """Return barriers with one h each, in the order of the file; those of a point say which.

    Args:
        barriers: As the scenario has them.
        model: Of the robot.

    Raises:
        ValueError: A barrier that the model cannot have, or a name that two would share.
    """
    single = tuple(one for barrier in barriers for one in _single(barrier, model))
    names = [barrier.name for barrier in single]
    if len(set(names)) != len(names):
        raise ValueError(f"filter.barriers: got names {names}, allowed each name once")
    return single


def _single(barrier: BarrierConfig, model: str) -> Iterator[SingleBarrier]:
    if isinstance(barrier, CoordinatesBarrier):
        for i, (low, high) in enumerate(zip(barrier.low, barrier.high, strict=True)):
            yield _limit(barrier, i, low, upper=False)
            yield _limit(barrier, i, high, upper=True)
        return
    points = POINTS[model]
    allowed = 2 if isinstance(barrier, ApartBarrier) else 1
    if points < allowed:
        got = f"barrier {barrier.name!r} of kind {barrier.kind!r} with model {model!r}"
        raise ValueError(f"filter.barriers: got {got}, allowed with a model of {allowed} or more points in the plane")
    if isinstance(barrier, ApartBarrier):
        yield barrier
        return
    if barrier.point is not None and barrier.point > points:
        got = f"point {barrier.point} of barrier {barrier.name!r} with model {model!r}"
        raise ValueError(f"filter.barriers: got {got}, allowed 1 to {points}")
    for point in range(1, points + 1) if barrier.point is None else (barrier.point,):
        name = barrier.name if barrier.point is not None or points == 1 else f"{barrier.name} {point}"
        update = {"name": name, "point": point}
        if isinstance(barrier, RoomBarrier):
            yield from _walls(barrier.model_copy(update=update))
        else:
            yield barrier.model_copy(update=update)


def _walls(room: RoomBarrier) -> Iterator[HalfPlaneBarrier]:
    for side, axis, sign in WALLS:
        place = room.low_m if sign > 0 else room.high_m
        yield HalfPlaneBarrier.model_construct(
            kind="half-plane",
            name=f"{room.name} {side}",
            normal=(sign, 0.0) if axis == 0 else (0.0, sign),
            offset=sign * place[axis],
            motion=None,
            point=room.point,
            class_k=room.class_k,
        )


def _limit(barrier: CoordinatesBarrier, index: int, bound: float, *, upper: bool) -> CoordinateLimit:
    return CoordinateLimit.model_construct(
        name=f"{barrier.name} {index + 1} {'high' if upper else 'low'}",
        of=barrier.of,
        index=index,
        bound=bound,
        upper=upper,
        class_k=barrier.class_k,
    )
