"""Follow a target smoothly: first-order, with the exact rate."""

from collections.abc import Sequence
from math import exp

from passafe_protocol.messages import Vector


class Follower:
    """Value that tends to a target: ẏ = (target − y)/T, between two calls the exact solution.

    Attributes:
        value: y.
        target: Where it tends to.
    """

    def __init__(self, size: int, time_constant_s: float) -> None:
        """Start at rest at zero.

        Args:
            size: Length of y.
            time_constant_s: T, s.
        """
        self.value: Vector = (0.0,) * size
        self.target: Vector = self.value
        self._rest = self.value
        self._time_constant_s = time_constant_s

    @property
    def rate(self) -> Vector:
        """Rate ẏ just after now, per second."""
        return tuple([(goal - y) / self._time_constant_s for goal, y in zip(self.target, self.value, strict=True)])

    def advance(self, elapsed_s: float) -> None:
        """Advance by a time, s."""
        left = exp(-elapsed_s / self._time_constant_s)
        self.value = tuple([goal + (y - goal) * left for goal, y in zip(self.target, self.value, strict=True)])

    def aim(self, target: Sequence[float]) -> None:
        """Tend to another target from now on."""
        self.target = tuple(target)

    def rest(self) -> None:
        """Be at rest at zero at once."""
        self.value = self.target = self._rest
