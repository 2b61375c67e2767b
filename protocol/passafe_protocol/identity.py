"""Identities: who a process is, as its certificate says and as access control knows it."""

import re
from dataclasses import dataclass
from typing import Final, Self

from passafe_protocol.errors import IdentityError
from passafe_protocol.keys import require_robot_name
from passafe_protocol.topics import READERS, TOPICS

ROUTER: Final = "router"
ROLES: Final = (
    *dict.fromkeys(role for topic in TOPICS for role in topic.publishers if role != ROUTER),
    *READERS,
)
"""Role of a process of a robot: every publisher of the topic table but the router, and what only reads."""

HOLDER_NAME_ALLOWED: Final = "1 to 32 lowercase letters, digits, - and _, the first a letter or digit"
_HOLDER_NAME: Final = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")


@dataclass(frozen=True, kw_only=True, slots=True, order=True)
class Identity:
    """Holder of a certificate: a process of a robot, or a router.

    Attributes:
        role: One of ``ROLES``, or ``router``.
        robot: The robot; empty for a router, which serves all robots of its deployment.
        name: Distinguishes holders of the same role, such as operators; may be empty.

    Raises:
        IdentityError: The role is unknown, a name has another form, or a router has a robot.
        RobotNameError: No robot can have this name.
    """

    role: str
    robot: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        if self.role == ROUTER:
            if self.robot:
                raise IdentityError("robot of a router", self.robot, "none")
        elif self.role in ROLES:
            require_robot_name(self.robot)
        else:
            raise IdentityError("role", self.role, ", ".join((ROUTER, *ROLES)))
        if self.name and _HOLDER_NAME.fullmatch(self.name) is None:
            raise IdentityError("name", self.name, HOLDER_NAME_ALLOWED)

    @property
    def common_name(self) -> str:
        """Common name of the certificate: ``operator.left-arm.alice``, ``filter.robot``, ``router``."""
        return ".".join(part for part in (self.role, self.robot, self.name) if part)

    @classmethod
    def of(cls, common_name: str) -> Self:
        """Return the identity with a common name.

        Raises:
            IdentityError: No identity has it.
            RobotNameError: No robot can have this name.
        """
        match common_name.split("."):
            case [role]:
                return cls(role=role)
            case [role, name] if role == ROUTER:
                return cls(role=role, name=name)
            case [role, robot]:
                return cls(role=role, robot=robot)
            case [role, robot, name] if name:
                return cls(role=role, robot=robot, name=name)
            case _:
                raise IdentityError("common name", common_name, "role.robot, role.robot.name, router or router.name")
