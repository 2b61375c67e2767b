"""Play-out buffer: holds inputs until the plant time at which they take effect."""

from operator import attrgetter
from typing import Final

from passafe_protocol.messages import PlantInput

MOST_PENDING: Final = 8192
"""Capacity, 8 s at 1 kHz: bounds the memory that a faulty sender can use."""

_TICK = attrgetter("tick")


class PlayoutBuffer:
    """Holds inputs by the period of the plant at whose beginning they take effect."""

    def __init__(self, period_ns: int) -> None:
        """Start empty.

        Args:
            period_ns: Period of the plant, ns; an effective time within a period is rounded up to the next one.
        """
        self._period_ns = period_ns
        self._pending: dict[int, PlantInput] = {}
        self._late: list[PlantInput] = []
        self._popped_period: int | None = None

    def put(self, plant_input: PlantInput) -> bool:
        """Add an input unless the buffer is full; of two for the same period the one of the newer tick is kept.

        Returns:
            Whether it was added.
        """
        if len(self._pending) >= MOST_PENDING:
            return False
        due = -(-plant_input.effective_plant_ns // self._period_ns)
        if self._popped_period is not None and due <= self._popped_period:
            self._late.append(plant_input)
            return True
        known = self._pending.get(due)
        if known is None or known.tick <= plant_input.tick:
            self._pending[due] = plant_input
        return True

    def void(self, plant_ns: int) -> None:
        """Discard all inputs for an emergency stop or its clear.

        Args:
            plant_ns: Plant time, ns.
        """
        self._pending.clear()
        self._late.clear()
        if self._popped_period is not None:
            self._popped_period = plant_ns // self._period_ns

    def pop_due(self, plant_ns: int) -> PlantInput | None:
        """Return the newest input due at ``plant_ns``, or ``None``, and remove it and all older ones.

        Args:
            plant_ns: Plant time, ns; after the first call, one period later than in the previous call.
        """
        period = plant_ns // self._period_ns
        exact = self._pending.pop(period, None)
        if self._popped_period is None:
            self._late += [self._pending.pop(due) for due in sorted(self._pending) if due < period]
        self._popped_period = period
        if not self._late:
            return exact
        candidates, self._late = self._late, []
        return max(candidates if exact is None else [exact, *candidates], key=_TICK)
