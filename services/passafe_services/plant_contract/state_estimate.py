"""Set of the states in which the robot can be, by the scenario's sets and all states that were read."""

from collections.abc import Sequence

from passafe_protocol.messages import Vector

from passafe.state_set import ErrorGrowth, StateSet


class StateEstimate:
    """Keeps the box of states that agree with the newest reading and with those before it.

    A state that is read narrows the box in which the sets let the robot be; the inputs in force between widen it. Guard
    and filter keep the same box of the same readings, so that what the filter found safe for its box is safe for the
    guard's, which lies within. A reading outside of what the sets allow shows that the sets are wrong: then the box
    begins anew about it.

    Attributes:
        newest: The box; ``None`` before the first reading.
        residual: How far the newest reading lies from the middle of what was allowed, n factors, at most 1 if the sets
            hold; empty where there was nothing to compare with.
    """

    def __init__(self, growth: ErrorGrowth) -> None:
        """Start with nothing read.

        Args:
            growth: Growth of errors by the scenario's sets.
        """
        self._growth = growth
        self.newest: StateSet | None = None
        self.residual: Vector = ()

    def restart(self) -> None:
        """Forget the readings so far."""
        self.newest, self.residual = None, ()

    @property
    def is_violated(self) -> bool:
        """Return whether the newest reading lies outside of what the sets allow."""
        return bool(self.residual) and max(self.residual) > 1.0

    def observe(self, x: Vector, inputs: Sequence[Vector] | None) -> StateSet:
        """Return the box after a reading.

        Args:
            x: State as read, n numbers.
            inputs: Input of every period since the reading before; ``None`` where they are not known.
        """
        growth, before = self._growth, self.newest
        allowed = None if before is None or inputs is None else growth.roll(before, inputs)
        self.residual = () if allowed is None else growth.residual(allowed, x)
        read = StateSet(center=x, radius=growth.at_measurement)
        self.newest = newest = read if allowed is None or self.is_violated else _common(allowed, read)
        return newest


def _common(one: StateSet, other: StateSet) -> StateSet:
    """Return the box of all states that are in both; they touch but for rounding at least."""
    center, radius = [], []
    for c, r, d, s in zip(one.center, one.radius, other.center, other.radius, strict=True):
        low, high = max(c - r, d - s), min(c + r, d + s)
        center.append((low + high) / 2)
        radius.append(max((high - low) / 2, 0.0))
    return StateSet(center=tuple(center), radius=tuple(radius))
