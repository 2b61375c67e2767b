"""Check of what a driver reads: what is no state of this robot at this time must not reach a law."""

from collections.abc import Sized
from math import isfinite
from typing import Final, TypeGuard

import numpy as np
from passafe_protocol.messages import Vector

from passafe.arguments.numbers import described, numbers
from passafe.errors import ShapeError
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.plant_driver import Reading

OLDEST_NS: Final = 50_000_000
"""Age of a reading beyond which the robot counts as blind, ns: until then the model leads from it to the present. One
that is so far ahead of the plant's clock is of another clock."""

_READING: Final = "reading"


class ReadingCheck:
    """Keeps the newest reading that is to be trusted.

    A reading of another form ends the process: waiting does not mend it. One whose numbers cannot be of this robot now
    counts as none, and the one before grows old.

    Attributes:
        newest: Newest trusted reading; ``None`` before there is one.
        refusal: Why the last reading was refused, in words; empty if it was not.
    """

    def __init__(self, states: int, *, has_own_clock: bool) -> None:
        """Start without a reading.

        Args:
            states: n.
            has_own_clock: Whether the driver says by a clock when it read; a simulation is at the time asked for.
        """
        self._states, self._has_own_clock = states, has_own_clock
        self.newest: Reading | None = None
        self.refusal = ""

    def check(self, read: object, at_ns: int) -> Reading | None:
        """Return the newest trusted reading after one more; ``None`` if the driver has none.

        Args:
            read: What the driver returned.
            at_ns: Time of the period, ns.

        Raises:
            DriverError: It is no reading of this robot.
        """
        self.refusal = ""
        if read is None:
            return None
        if not isinstance(read, Reading):
            raise DriverError(_READING, described(read), "a Reading or None")
        x, true_x, read_ns = self._numbers(read.x, "x"), self._numbers(read.true_x, "true_x"), _whole(read.at_ns)
        self.refusal = self._against(x, true_x, read_ns, at_ns)
        if not self.refusal and (self.newest is None or read_ns >= self.newest.at_ns):
            self.newest = Reading(x, read_ns, None, true_x)
        return self.newest

    def refuse(self, why: str) -> None:
        """Count the newest reading as none, for a reason that shows only when the model is evaluated at it."""
        self.newest, self.refusal = None, why

    def _numbers(self, given: object, name: str) -> Vector:
        """Return n numbers, or none where the true state is not known."""
        if name == "true_x" and isinstance(given, Sized) and len(given) == 0:
            return ()
        try:
            found = given if _is_plain(given) else numbers(name, given)
        except ShapeError as error:
            raise DriverError(f"{_READING} {name}", described(given), f"{self._states} numbers") from error
        if len(found) != self._states:
            raise DriverError(f"{_READING} {name}", f"{len(found)} numbers", f"{self._states} numbers")
        return found

    def _against(self, x: Vector, true_x: Vector, read_ns: int, at_ns: int) -> str:
        """Return what speaks against a reading, in words; empty: nothing."""
        if not all(map(isfinite, x)) or not all(map(isfinite, true_x)):
            return f"x: got {x}, allowed finite numbers"
        if self._has_own_clock and read_ns - at_ns > OLDEST_NS:
            ahead_s = (read_ns - at_ns) * 1e-9
            return f"its time: got {ahead_s:.3g} s ahead of the plant's clock, allowed at most {OLDEST_NS * 1e-9:g} s"
        return ""


def _is_plain(given: object) -> TypeGuard[Vector]:
    """Return whether that is a tuple of floats already, as most drivers return it at every period."""
    return type(given) is tuple and all(type(number) is float for number in given)


def _whole(given: object) -> int:
    """Return a time in whole nanoseconds."""
    if not isinstance(given, int | float | np.integer | np.floating) or not isfinite(given):
        raise DriverError(f"{_READING} at_ns", described(given), "a whole number of ns")
    return int(given)
