"""Messages of passafe as the standard messages of ROS 2."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import cos, sin
from typing import Any, Final, NamedTuple

import numpy as np
from passafe_protocol.messages import Event, FilterTick, Header, Health, OperatorCommand, PlantInput, PlantState
from rosbags.typesys import Stores, get_typestore

from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.joint_motion import JointMotion
from passafe_services.scenarios.schema import Scenario

STORE: Final = get_typestore(Stores.ROS2_HUMBLE)
"""Types of Humble, whose standard messages later releases have unchanged."""

WORLD: Final = "world"
_NS_PER_S: Final = 1_000_000_000
_LEVELS: Final = {"info": 20, "warning": 30, "error": 40}
"""Levels of ``rcl_interfaces/msg/Log``."""

_OK: Final = 0
_WARN: Final = 1


class RosMessage(NamedTuple):
    """One message of a bag.

    Attributes:
        topic: Its topic.
        type_name: Its type, such as ``geometry_msgs/msg/PoseStamped``.
        message: The message, as ``rosbags`` has it.
    """

    topic: str
    type_name: str
    message: Any


class RosMessages:
    """Converter of the messages of one robot.

    Args:
        scenario: Its scenario; without one there are no poses.
    """

    def __init__(self, scenario: Scenario | None) -> None:
        robot = None if scenario is None else robot_of(scenario)
        self._drawn = None if robot is None else DrawnPlaces.of(robot)
        self._points = 0 if self._drawn is None else self._drawn.count
        self._joints = None if robot is None else JointMotion.of(robot, self._points)
        self._of_body: Mapping[type, Callable[[Header, Any, int], Iterator[RosMessage]]] = {
            PlantState: self._state,
            FilterTick: self._tick,
            PlantInput: self._input,
            OperatorCommand: self._command,
            Event: self._event,
            Health: self._health,
        }

    def messages(self, header: Header, body: object, time_ns: int) -> Iterator[RosMessage]:
        """Yield what a message of passafe is in ROS 2; nothing for one that has no counterpart."""
        convert = self._of_body.get(type(body))
        if convert is not None:
            yield from convert(header, body, time_ns)

    def _state(self, _sender: Header, body: PlantState, time_ns: int) -> Iterator[RosMessage]:
        places, heading, speeds = ([], None, []) if self._drawn is None else self._drawn.at(body.x)
        for k, place in enumerate(places):
            speed = speeds[k] if k < len(speeds) else (0.0, 0.0)
            suffix = "" if self._points == 1 else f"_{k + 1}"
            frame = f"robot{suffix}"
            pose = _make("geometry_msgs/msg/Pose", position=_point(place), orientation=_turned(heading))
            yield _stamped(f"/passafe/pose{suffix}", "geometry_msgs/msg/PoseStamped", time_ns, WORLD, pose=pose)
            twist = _make("geometry_msgs/msg/Twist", linear=_vector(speed), angular=_vector((0.0, 0.0)))
            yield _stamped(f"/passafe/twist{suffix}", "geometry_msgs/msg/TwistStamped", time_ns, WORLD, twist=twist)
            transform = _make("geometry_msgs/msg/Transform", translation=_vector(place), rotation=_turned(heading))
            stamped = _make(
                "geometry_msgs/msg/TransformStamped",
                header=_header(time_ns, WORLD),
                child_frame_id=frame,
                transform=transform,
            )
            yield RosMessage("/tf", "tf2_msgs/msg/TFMessage", _make("tf2_msgs/msg/TFMessage", transforms=[stamped]))
        if self._joints is not None and self._joints.count:
            positions, velocities, efforts = self._joints.at(body.x, body.u)
            yield _stamped(
                "/joint_states",
                "sensor_msgs/msg/JointState",
                time_ns,
                "",
                name=[f"joint_{k + 1}" for k in range(self._joints.count)],
                position=np.array(positions),
                velocity=np.array(velocities),
                effort=np.array(efforts),
            )
        yield _array("/passafe/state", body.x)
        yield _text("/passafe/phase", body.phase.name)

    def _tick(self, _sender: Header, body: FilterTick, _time_ns: int) -> Iterator[RosMessage]:
        yield _text("/passafe/status", body.status.name)
        yield _number("/passafe/tank", body.tank_j)
        yield _number("/passafe/power_margin", body.power_margin)
        yield _number("/passafe/state_age", body.state_age_ns / _NS_PER_S)
        yield _number("/passafe/command_age", body.command_age_ns / _NS_PER_S)
        for report in body.barriers:
            if report.psi:
                yield _number(f"/passafe/barrier/{_name(report.name)}", report.psi[0])

    def _input(self, _sender: Header, body: PlantInput, _time_ns: int) -> Iterator[RosMessage]:
        yield _array("/passafe/input", body.u)

    def _command(self, _sender: Header, body: OperatorCommand, _time_ns: int) -> Iterator[RosMessage]:
        yield _array("/passafe/command", body.u_h)

    def _event(self, sender: Header, body: Event, time_ns: int) -> Iterator[RosMessage]:
        level = _LEVELS.get(body.severity, 0)
        line = _make(
            "rcl_interfaces/msg/Log",
            stamp=_time(time_ns),
            level=level,
            name=sender.source,
            msg=body.text,
            file="",
            function="",
            line=0,
        )
        yield RosMessage("/rosout", "rcl_interfaces/msg/Log", line)

    def _health(self, sender: Header, body: Health, time_ns: int) -> Iterator[RosMessage]:
        values = {"rate_hz": body.rate_hz, "overruns": body.overruns, "steps_skipped": body.steps_skipped}
        values |= {"late_us_max": body.late_us_max}
        for topic in body.topics:
            values |= {f"{topic.topic}_gaps": topic.gaps, f"{topic.topic}_refused": topic.refused}
        troubled = any(topic.gaps or topic.refused for topic in body.topics)
        status = _make(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=_WARN if troubled else _OK,
            name=sender.source,
            message="messages missing or refused" if troubled else "ok",
            hardware_id="",
            values=[_make("diagnostic_msgs/msg/KeyValue", key=key, value=f"{value}") for key, value in values.items()],
        )
        yield _stamped("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", time_ns, "", status=[status])


def _make(type_name: str, **fields: Any) -> Any:  # noqa: ANN401 - a class that the type store makes at run time
    return STORE.types[type_name](**fields)


def _stamped(topic: str, type_name: str, time_ns: int, frame: str, **fields: Any) -> RosMessage:  # noqa: ANN401 - as above
    return RosMessage(topic, type_name, _make(type_name, header=_header(time_ns, frame), **fields))


def _array(topic: str, values: Sequence[float]) -> RosMessage:
    type_name = "std_msgs/msg/Float64MultiArray"
    dimension = _make("std_msgs/msg/MultiArrayDimension", label="", size=len(values), stride=len(values))
    layout = _make("std_msgs/msg/MultiArrayLayout", dim=[dimension], data_offset=0)
    return RosMessage(topic, type_name, _make(type_name, layout=layout, data=np.array(values, dtype=np.float64)))


def _number(topic: str, value: float) -> RosMessage:
    return RosMessage(topic, "std_msgs/msg/Float64", _make("std_msgs/msg/Float64", data=value))


def _text(topic: str, value: str) -> RosMessage:
    return RosMessage(topic, "std_msgs/msg/String", _make("std_msgs/msg/String", data=value))


def _header(time_ns: int, frame: str) -> Any:  # noqa: ANN401 - as above
    return _make("std_msgs/msg/Header", stamp=_time(time_ns), frame_id=frame)


def _time(time_ns: int) -> Any:  # noqa: ANN401 - as above
    return _make("builtin_interfaces/msg/Time", sec=time_ns // _NS_PER_S, nanosec=time_ns % _NS_PER_S)


def _point(place: Sequence[float]) -> Any:  # noqa: ANN401 - as above
    return _make("geometry_msgs/msg/Point", x=place[0], y=place[1], z=0.0)


def _vector(vector: Sequence[float]) -> Any:  # noqa: ANN401 - as above
    return _make("geometry_msgs/msg/Vector3", x=vector[0], y=vector[1], z=0.0)


def _turned(heading: float | None) -> Any:  # noqa: ANN401 - as above
    """Return the rotation by an angle in the plane; upright without one."""
    half = 0.0 if heading is None else heading / 2
    return _make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=sin(half), w=cos(half))


def _name(name: str) -> str:
    """Return a name as part of a topic, whose parts begin with a letter."""
    word = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_") or "unnamed"
    return word if word[0].isalpha() else f"b_{word}"
