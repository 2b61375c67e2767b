"""Key expressions of the bus, ``passafe/{robot}/{source}/{topic}``: how they are written and read."""

import re
from typing import Final, NamedTuple

from passafe_protocol.errors import RobotNameError

KEY_ROOT: Final = "passafe"
DEFAULT_ROBOT: Final = "robot"
"""Robot of a system that names none."""

ROBOT_NAME_ALLOWED: Final = "1 to 32 lowercase letters, digits, - and _, the first a letter or digit"
_ROBOT_NAME: Final = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")


class KeyParts(NamedTuple):
    """Parts of a key expression.

    Attributes:
        robot: Name of the robot; empty in logs of passafe 0.2, whose keys name none.
        source: Process that publishes it.
        topic: Name of the topic, not necessarily one of the table.
    """

    robot: str
    source: str
    topic: str


def key_of(robot: str, source: str, topic: str) -> str:
    """Return the key expression of a topic as published by a process of a robot; each part may be a ``*``."""
    return f"{KEY_ROOT}/{robot}/{source}/{topic}"


def parts_of(key: str) -> KeyParts | None:
    """Return the parts of a key expression; ``None`` for one that is not of passafe."""
    root, *chunks = key.split("/")
    match chunks:
        case [robot, source, topic] if root == KEY_ROOT:
            return KeyParts(robot, source, topic)
        case [source, topic] if root == KEY_ROOT:
            return KeyParts("", source, topic)
        case _:
            return None


def require_robot_name(name: str) -> str:
    """Return the name of a robot.

    Raises:
        RobotNameError: It cannot be part of a key expression and of a certificate's name.
    """
    if _ROBOT_NAME.fullmatch(name) is None:
        raise RobotNameError(name, ROBOT_NAME_ALLOWED)
    return name
