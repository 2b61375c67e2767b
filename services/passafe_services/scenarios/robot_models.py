"""Robot models that a scenario may name: the function that builds each, its parameters, points and units."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.joint_chain import joint_chain
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.models.saturating_point import saturating_point
from passafe.models.two_points import two_points


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotModel:
    """One model of the core.

    Attributes:
        name: Its name in a scenario file.
        build: Function of the core that returns the robot.
        parameters: Names of the parameters that a scenario may set.
        points: Number of points in the plane that the robot moves; 0 for joints.
        commands: Coordinates of a command; ``None``: two for each point, one for each joint.
        spheres: Names of the spheres that cover its body.
        position_unit: Unit of a coordinate of the position.
        input_unit: Unit of u: a force on a unit of mass, a torque on a unit of inertia.
    """

    name: str
    build: Callable[..., Robot]
    parameters: tuple[str, ...] = ("sigma", "mass")
    points: int = 1
    commands: int | None = None
    spheres: tuple[str, ...] = ()
    position_unit: str = "m"
    input_unit: str = "m/s²"


ROBOT_MODELS: Final = {
    model.name: model
    for model in (
        RobotModel(name="damped-point", build=damped_point),
        RobotModel(name="drag-point", build=drag_point, parameters=("sigma", "drag", "mass")),
        RobotModel(name="lagged-point", build=lagged_point, parameters=("sigma", "lag_s", "mass")),
        RobotModel(name="saturating-point", build=saturating_point, parameters=("sigma", "force", "mass")),
        RobotModel(name="two-points", build=two_points, points=2),
        RobotModel(
            name="joint-chain",
            build=joint_chain,
            parameters=("sigma",),
            points=0,
            position_unit="rad",
            input_unit="rad/s²",
        ),
    )
}
"""Every model by its name."""
