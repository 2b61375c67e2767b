"""Emergency stop of the plant: latched by any press, cleared by its name alone."""

from collections import deque
from typing import Final

from passafe_protocol.messages import EmergencyStop, Event, PlantInput, Received, StopClear

SPENT: Final = 64
"""Presses that are remembered after they were cleared: a repeat that was still on its way latches nothing."""

NO_STOP: Final = 0


class StopLatch:
    """Latch of the emergency stop, and the gate for inputs.

    Every press has a random id, and the newest one names the stop. A clear that names another stop, such as one that
    its sender had not yet seen, has no effect. An input is admitted only if it was decided with knowledge of the last
    clear (``PlantInput.stops_cleared``): what waited in a queue, a link or a buffer meanwhile is void for good.

    Attributes:
        stop: Id of the newest press of the stop that is latched; 0: none.
        source: Process that pressed it; empty: none.
        cleared: Number of stops cleared.
    """

    def __init__(self, started_with: int = NO_STOP) -> None:
        """Start without a stop, or with one latched.

        Args:
            started_with: Id of the stop that is latched from the start; 0: none.
        """
        self.stop = started_with
        self.source = "plant" if started_with else ""
        self.cleared = 0
        self._presses: deque[int] = deque([started_with] if started_with else [], maxlen=SPENT)
        self._spent: deque[int] = deque(maxlen=SPENT)
        self._has_refused = False

    @property
    def is_latched(self) -> bool:
        """True while a stop is in force."""
        return self.stop != NO_STOP

    def admits(self, plant_input: PlantInput) -> bool:
        """Return whether an input may count: no stop is latched, and its filter knew of the last clear."""
        return self.stop == NO_STOP and plant_input.stops_cleared == self.cleared

    def receive(self, received: Received) -> Event | None:
        """Receive a press or a clear; return an event if the latch changed, or a clear was refused."""
        body, source = received.body, received.header.source
        if isinstance(body, EmergencyStop):
            return self._press(body, source)
        return self._clear(body, source) if isinstance(body, StopClear) else None

    def _press(self, press: EmergencyStop, source: str) -> Event | None:
        if press.id in self._spent:
            return None
        was_latched, self.stop, self.source = self.is_latched, press.id, source
        if press.id not in self._presses:
            self._presses.append(press.id)
        if was_latched:
            return None
        self._has_refused = False
        return Event("warning", f"emergency stop latched, pressed at {source}: {press.reason}")

    def _clear(self, clear: StopClear, source: str) -> Event | None:
        if not self.is_latched:
            return None
        if clear.stop != self.stop:
            if self._has_refused:
                return None
            self._has_refused = True
            return Event("warning", f"refused to clear: got stop {clear.stop}, allowed {self.stop}, the one latched")
        self._spent += self._presses
        self._presses.clear()
        self.stop, self.source = NO_STOP, ""
        self.cleared += 1
        return Event("info", f"emergency stop cleared at {source}: {clear.reason}")
