"""Robots that passafe brings beside the models of the core: as those of other distributions, logs carry them."""

from collections.abc import Callable, Mapping
from typing import Final

from passafe.models.robot import Robot
from passafe.models.seven_joint_arm import seven_joint_arm
from passafe.models.unicycle import unicycle

SHIPPED: Final[Mapping[str, Callable[..., Robot]]] = {"seven-joint-arm": seven_joint_arm, "unicycle": unicycle}
"""Functions by the name that a scenario gives as its model."""
