"""Command of a source at one instant."""

from msgspec import Struct
from passafe_protocol.messages import Vector


class Command(Struct, frozen=True, gc=False):
    """Command at one instant.

    Attributes:
        u_h: Operator's part of the input, units of u.
        u_h_rate: Its time derivative just after that instant, units of u per second.
        enabled: Whether the dead-man switch is held.
    """

    u_h: Vector
    u_h_rate: Vector
    enabled: bool
