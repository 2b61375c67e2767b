"""One number for each state of a robot, given as a list or by parts of the state."""

from typing import Annotated, TypeAlias, TypeVar

import casadi as ca
from pydantic import Discriminator, Field, Tag

from passafe.models.robot import Robot
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.fields import LISTED, SINGLE, Config, Finite, NonNegative, single_or_listed

Parts = TypeVar("Parts")
Number = TypeVar("Number")


class StateParts(Config):
    """One number for each part of the state, all its coordinates alike.

    Attributes:
        position: Of each coordinate of the position.
        velocity: Of each coordinate of the velocity.
        other: Of every other state.
    """

    position: Finite = 0.0
    velocity: Finite = 0.0
    other: Finite = 0.0


class StateBounds(Config):
    """One bound for each part of the state, all its coordinates alike.

    Attributes:
        position: Of each coordinate of the position.
        velocity: Of each coordinate of the velocity.
        other: Of every other state.
    """

    position: NonNegative = 0.0
    velocity: NonNegative = 0.0
    other: NonNegative = 0.0


_Listed: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=1, max_length=64), Tag(LISTED)]
_PartsOrListed: TypeAlias = Annotated[Annotated[Parts, Tag(SINGLE)] | _Listed[Number], Discriminator(single_or_listed)]
PerState: TypeAlias = _PartsOrListed[StateParts, Finite]
BoundPerState: TypeAlias = _PartsOrListed[StateBounds, NonNegative]


def state_numbers(
    scenario: str, field: str, given: StateParts | StateBounds | tuple[float, ...], robot: Robot
) -> tuple[float, ...]:
    """Return one number for each state of a robot, n numbers.

    Args:
        scenario: Name of the scenario, for errors.
        field: Dotted name of the field.
        given: Its value.
        robot: The robot.

    Raises:
        ScenarioError: A list of another length than the robot has states.
    """
    n, x = robot.system.n, robot.system.x
    if isinstance(given, tuple):
        if len(given) != n:
            raise ScenarioError(scenario, field, f"{len(given)} numbers", f"{n}, the states of the model, or a table")
        return given
    positions, velocities = ca.symvar(robot.position), ca.symvar(robot.velocity)

    def is_among(i: int, symbols: list[ca.SX]) -> bool:
        return any(ca.is_equal(x[i], symbol) for symbol in symbols)

    return tuple(
        given.position if is_among(i, positions) else given.velocity if is_among(i, velocities) else given.other
        for i in range(n)
    )
