"""The play-out buffer: inputs wait for the plant time at which they take effect."""

from operator import attrgetter
from typing import Final

from passafe_protocol.messages import PlantInput

MOST_WAITING: Final = 8192
"""Inputs that may wait at a time, 8 s at 1 kHz: a sender of nonsense fills no memory."""

_TICK = attrgetter("tick")


class PlayoutBuffer:
    """Inputs that have not taken effect yet, by the period of the plant at whose beginning they will.

    Attributes:
        received_tick: Filter tick of the newest input taken in; 0 before the first.
    """

    def __init__(self, period_ns: int) -> None:
        """Start empty.

        Args:
            period_ns: Period of the plant; an effective time within a period counts as the beginning of the next.
        """
        self._period_ns = period_ns
        self._waiting: dict[int, PlantInput] = {}
        self._late: list[PlantInput] = []
        self._taken: int | None = None
        self.received_tick = 0

    def put(self, plant_input: PlantInput) -> bool:
        """Take an input in, unless the buffer is full; of two for the same period the newer tick counts.

        Returns:
            Whether there was room for it.
        """
        if len(self._waiting) >= MOST_WAITING:
            return False
        self.received_tick = max(self.received_tick, plant_input.tick)
        due = -(-plant_input.effective_plant_ns // self._period_ns)
        if self._taken is not None and due <= self._taken:
            self._late.append(plant_input)
            return True
        known = self._waiting.get(due)
        if known is None or known.tick <= plant_input.tick:
            self._waiting[due] = plant_input
        return True

    def take(self, plant_ns: int) -> PlantInput | None:
        """Return the newest input whose effect is due at ``plant_ns``, or ``None``; forget it and all older ones.

        Args:
            plant_ns: Plant time; after the first call, one period later than in the call before.
        """
        period = plant_ns // self._period_ns
        exact = self._waiting.pop(period, None)
        if self._taken is None:
            self._late += [self._waiting.pop(due) for due in sorted(self._waiting) if due < period]
        self._taken = period
        if not self._late:
            return exact
        candidates, self._late = self._late, []
        return max(candidates if exact is None else [exact, *candidates], key=_TICK)
