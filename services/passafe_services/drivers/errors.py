"""Errors of plant drivers."""

from passafe.errors import NotAllowedError


class DriverError(NotAllowedError):
    """A driver that cannot read or move its robot, and will not by waiting."""

    prefix = "driver "
