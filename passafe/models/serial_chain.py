"""Kinematics of a chain of revolute joints, by modified Denavit–Hartenberg parameters (Craig 2005, chapter 3)."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, sin
from typing import NamedTuple

import casadi as ca

from passafe.errors import DesignError

EXACT = 1e-12
"""Sines and cosines of the fixed angles that are this near to a whole number are that number."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RevoluteJoint:
    """One row of the table: where the joint's axis lies in the frame of the link before.

    Attributes:
        a_m: Distance of the axes along x of the link before, m.
        d_m: Distance along the joint's own axis, m.
        alpha_rad: Angle of the axes about x of the link before, rad.
    """

    a_m: float
    d_m: float
    alpha_rad: float

    @property
    def origin(self) -> ca.DM:
        """Return where the joint's frame lies in that of the link before, m, shape (3, 1)."""
        return ca.DM([self.a_m, -_exact(sin(self.alpha_rad)) * self.d_m, _exact(cos(self.alpha_rad)) * self.d_m])

    @property
    def twist(self) -> ca.DM:
        """Return the rotation of the joint's frame in that of the link before, at angle 0, shape (3, 3)."""
        c, s = _exact(cos(self.alpha_rad)), _exact(sin(self.alpha_rad))
        return ca.sparsify(ca.DM([[1, 0, 0], [0, c, -s], [0, s, c]]))


class Frame(NamedTuple):
    """Frame of a link in that of the base.

    Attributes:
        rotation: Shape (3, 3).
        origin: m, shape (3, 1).
    """

    rotation: ca.SX
    origin: ca.SX

    def place(self, offset: Sequence[float] | ca.DM) -> ca.SX:
        """Return a point of the link in the frame of the base, m, shape (3, 1)."""
        return self.origin + self.rotation @ ca.DM(offset)


@dataclass(frozen=True, kw_only=True, slots=True)
class SerialChain:
    """Links 0 to k, the base first, with a joint between any two that follow one another.

    Attributes:
        joints: Joint i turns link i, i from 1.
    """

    joints: tuple[RevoluteJoint, ...]

    def __post_init__(self) -> None:
        """Refuse a chain without joints."""
        if not self.joints:
            raise DesignError("serial chain joints", "none", "one or more")

    def frames(self, q: ca.SX) -> tuple[Frame, ...]:
        """Return the frames of all links, the base's first.

        Args:
            q: Angles, rad, shape (k, 1).
        """
        frames = [Frame(ca.SX.eye(3), ca.SX.zeros(3))]
        for i, joint in enumerate(self.joints):
            before = frames[-1]
            rotation = ca.sparsify(before.rotation @ joint.twist @ turn(q[i]))
            frames.append(Frame(rotation, before.place(joint.origin)))
        return tuple(frames)

    def lengths(self, link: int, offset: Sequence[float], since: int = 0) -> tuple[float, ...]:
        """Return the lengths of the vectors that lead to a point of a link, m, by the last joint that turns them.

        Args:
            link: The link.
            offset: The point in its frame, m.
            since: Link from whose frame the point is seen: joints up to it do not count.

        Returns:
            |lᵢ| for the joints ``since`` + 1 to ``link``.
        """
        origins = [joint.origin for joint in self.joints[since + 1 : link]]
        return (*(float(ca.norm_2(origin)) for origin in origins), hypot(*offset))


def turn(angle: ca.SX) -> ca.SX:
    """Return the rotation about z, shape (3, 3)."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.sparsify(ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1)))


def _exact(value: float) -> float:
    return float(round(value)) if abs(value - round(value)) < EXACT else value
