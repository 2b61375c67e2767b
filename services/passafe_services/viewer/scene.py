"""Scene of a run in Foxglove's schemas: the robot's points or joints, its inputs, and the barriers."""

from collections.abc import Iterator, Sequence
from math import atan2, cos, hypot, sin
from typing import Any, Final

import numpy as np
from foxglove_schemas_protobuf.ArrowPrimitive_pb2 import ArrowPrimitive
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from passafe_protocol.messages import FilterTick, PlantState

from passafe_services.scenarios.barrier_kinds.outline import Outline
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.joint_motion import JointMotion
from passafe_services.scenarios.schema import Scenario
from passafe_services.viewer.view_message import ViewMessage, ViewTopic, timestamp

WORLD: Final = "world"
ROBOT: Final = ViewTopic(name="/passafe/scene/robot", message_type=SceneUpdate)
BARRIERS: Final = ViewTopic(name="/passafe/scene/barriers", message_type=SceneUpdate)
TRANSFORMS: Final = ViewTopic(name="/tf", message_type=FrameTransforms)
POSES: Final = ViewTopic(name="/passafe/poses", message_type=PosesInFrame)
JOINTS: Final = ViewTopic(name="/passafe/joints", message_type=JointStates)

ROBOT_M: Final = 0.08
"""Diameter of the ball that stands for a point."""

ARROW_M_PER_INPUT: Final = 0.05
"""Length of an arrow for one unit of input."""

LONGEST_ARROW_M: Final = 1.0
_STILL: Final = 1e-6

_ASKED: Final = Color(r=0.45, g=0.45, b=0.5, a=0.9)
_SENT: Final = Color(r=0.1, g=0.4, b=0.85, a=1.0)
_POINT: Final = Color(r=0.1, g=0.4, b=0.85, a=1.0)
_KEPT: Final = Color(r=0.55, g=0.6, b=0.65, a=1.0)
_BINDS: Final = Color(r=0.9, g=0.55, b=0.1, a=1.0)
_VIOLATED: Final = Color(r=0.85, g=0.1, b=0.1, a=1.0)
_FILL_ALPHA: Final = 0.35


class Scene:
    """Scene of one robot.

    Args:
        scenario: Its scenario.
    """

    def __init__(self, scenario: Scenario) -> None:
        robot = robot_of(scenario)
        self._drawn = DrawnPlaces.of(robot)
        self._points = self._drawn.count
        self._joints = JointMotion.of(robot, self._points)
        self._outlines = [(one.name, one.outline) for one in scenario.barriers if one.outline is not None]

    def robot(self, state: PlantState, tick: FilterTick | None, time_ns: int) -> Iterator[ViewMessage]:
        """Yield the robot at a state: transforms, poses and balls of its points, or the states of its joints.

        Args:
            state: The state.
            tick: Newest decision, whose inputs are drawn; ``None`` before the first.
            time_ns: Time of the state.
        """
        if self._joints.count:
            yield ViewMessage(JOINTS, self._joint_states(state, time_ns), time_ns)
        if not self._points:
            return
        places, heading, _ = self._drawn.at(state.x)
        frames = ["robot" if self._points == 1 else f"robot_{k + 1}" for k in range(self._points)]
        stamp = timestamp(time_ns)
        transforms = [
            FrameTransform(
                timestamp=stamp,
                parent_frame_id=WORLD,
                child_frame_id=frame,
                translation=Vector3(x=x, y=y),
                rotation=_turned(heading),
            )
            for frame, (x, y) in zip(frames, places, strict=True)
        ]
        yield ViewMessage(TRANSFORMS, FrameTransforms(transforms=transforms), time_ns)
        poses = [_pose(*place, heading) for place in places]
        yield ViewMessage(POSES, PosesInFrame(timestamp=stamp, frame_id=WORLD, poses=poses), time_ns)
        size = Vector3(x=ROBOT_M, y=ROBOT_M, z=ROBOT_M)
        entities = [
            SceneEntity(
                timestamp=stamp,
                frame_id=WORLD,
                id=frame,
                spheres=[SpherePrimitive(pose=_pose(*place), size=size, color=_POINT)],
                lines=self._body(place, heading),
                arrows=[] if tick is None else self._arrows(tick, k, place),
            )
            for k, (frame, place) in enumerate(zip(frames, places, strict=True))
        ]
        yield ViewMessage(ROBOT, SceneUpdate(entities=entities), time_ns)

    def _body(self, place: tuple[float, float], heading: float | None) -> list[Any]:
        """Return the outline of the body, if the robot has one."""
        if heading is None:
            return []
        corners = [Point3(x=x, y=y) for x, y in self._drawn.outline]
        pose = _pose(*place, heading)
        return [LinePrimitive(type=LinePrimitive.LINE_LOOP, pose=pose, thickness=0.02, points=corners, color=_POINT)]

    def _arrows(self, tick: FilterTick, point: int, place: tuple[float, float]) -> list[Any]:
        """Return the arrows of what was asked for and of what was sent to a point."""
        found = []
        for vector, colour in ((tick.u_nominal, _ASKED), (tick.u, _SENT)):
            pushed = self._drawn.push(tick.x_hat, vector)[2 * point : 2 * point + 2]
            arrow = _arrow(pushed, place, colour) if pushed else None  # what is drawn may be more than what is pushed
            found += [] if arrow is None else [arrow]
        return found

    def barriers(self, plant_ns: int, tick: FilterTick | None, time_ns: int) -> Iterator[ViewMessage]:
        """Yield the outlines of all barriers at a plant time: grey, orange where the row binds, red where h < 0."""
        if not self._outlines:
            return
        t_s = np.array([plant_ns * 1e-9])
        entities = []
        for name, outline in self._outlines:
            moved = outline.displacements_m(t_s)[:, 0]
            entities.append(_barrier(name, outline, (float(moved[0]), float(moved[1])), _colour(name, tick), time_ns))
        yield ViewMessage(BARRIERS, SceneUpdate(entities=entities), time_ns)

    def _joint_states(self, state: PlantState, time_ns: int) -> Any:  # noqa: ANN401 - a class that protobuf makes at run time
        places, speeds, efforts = self._joints.at(state.x, state.u)
        joints = [
            JointState(name=f"joint_{k + 1}", position=place, velocity=speed, effort=efforts[k] if efforts else 0.0)
            for k, (place, speed) in enumerate(zip(places, speeds, strict=True))
        ]
        return JointStates(timestamp=timestamp(time_ns), joints=joints)


def _barrier(name: str, outline: Outline, moved: tuple[float, float], colour: Any, time_ns: int) -> Any:  # noqa: ANN401 - as above
    pose = _pose(*moved)
    border = [Point3(x=x, y=y) for x, y in outline.border]
    entity = SceneEntity(timestamp=timestamp(time_ns), frame_id=WORLD, id=name)
    entity.lines.append(
        LinePrimitive(
            type=LinePrimitive.LINE_STRIP, pose=pose, thickness=2.0, scale_invariant=True, points=border, color=colour
        )
    )
    if outline.is_bounded:
        fan = [corner for k in range(1, len(border) - 2) for corner in (0, k, k + 1)]
        fill = Color(r=colour.r, g=colour.g, b=colour.b, a=_FILL_ALPHA)
        entity.triangles.append(TriangleListPrimitive(pose=pose, points=border, indices=fan, color=fill))
    return entity


def _colour(name: str, tick: FilterTick | None) -> Any:  # noqa: ANN401 - as above
    if tick is None:
        return _KEPT
    if any(report.name == name and report.psi and report.psi[0] < 0.0 for report in tick.barriers):
        return _VIOLATED
    return _BINDS if any(row.name == name and row.active for row in tick.rows) else _KEPT


def _arrow(vector: Sequence[float], place: tuple[float, float], colour: Any) -> Any:  # noqa: ANN401 - as above
    length = min(hypot(*vector) * ARROW_M_PER_INPUT, LONGEST_ARROW_M)
    if length < _STILL:
        return None
    half = 0.5 * atan2(vector[1], vector[0])
    pose = _pose(*place)
    pose.orientation.CopyFrom(Quaternion(z=sin(half), w=cos(half)))
    return ArrowPrimitive(
        pose=pose,
        shaft_length=0.8 * length,
        shaft_diameter=0.02,
        head_length=0.2 * length,
        head_diameter=0.05,
        color=colour,
    )


def _pose(x: float, y: float, heading: float | None = None) -> Any:  # noqa: ANN401 - as above
    return Pose(position=Vector3(x=x, y=y), orientation=_turned(heading))


def _turned(heading: float | None) -> Any:  # noqa: ANN401 - as above
    """Return the rotation by an angle in the plane."""
    return Quaternion(w=1.0) if heading is None else Quaternion(z=sin(heading / 2), w=cos(heading / 2))
