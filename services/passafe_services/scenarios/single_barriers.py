"""A scenario's barriers with one h each: a room is four walls, every coordinate has two limits, every point its own."""

from collections.abc import Sequence

from passafe_services.scenarios.barrier_kinds.barrier_kind import BarrierKind, SingleBarrier
from passafe_services.scenarios.robot_models import RobotModel


def single_barriers(barriers: Sequence[BarrierKind], model: RobotModel) -> tuple[SingleBarrier, ...]:
    """Return barriers with one h each, in the order of the file.

    Args:
        barriers: As the scenario has them.
        model: Of the robot.

    Raises:
        ValueError: A barrier that the model cannot have, or a name that two would share.
    """
    for barrier in barriers:
        if model.points < barrier.least_points:
            got = f"barrier {barrier.name!r} of kind {barrier.kind!r} with model {model.name!r}"
            allowed = f"a model of {barrier.least_points} or more points in the plane"
            raise ValueError(f"filter.barriers: got {got}, allowed with {allowed}")
    single = tuple(one for barrier in barriers for one in barrier.split(model))
    names = [barrier.name for barrier in single]
    if len(set(names)) != len(names):
        raise ValueError(f"filter.barriers: got names {names}, allowed each name once")
    return single
