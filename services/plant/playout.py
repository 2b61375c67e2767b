"""The play-out buffer: inputs wait for the plant time at which they take effect."""

from protocol.messages import PlantInput


class PlayoutBuffer:
    """Inputs that have not taken effect yet, by the plant time at which they will.

    Attributes:
        received_tick: Filter tick of the newest input taken in; 0 before the first.
    """

    def __init__(self) -> None:
        self._waiting: dict[int, PlantInput] = {}
        self.received_tick = 0

    def put(self, plant_input: PlantInput) -> None:
        """Take an input in; of two for the same plant time the newer tick counts."""
        due = plant_input.effective_plant_ns
        known = self._waiting.get(due)
        if known is None or known.tick <= plant_input.tick:
            self._waiting[due] = plant_input
        self.received_tick = max(self.received_tick, plant_input.tick)

    def take(self, plant_ns: int) -> PlantInput | None:
        """Return the newest input whose effect is due at ``plant_ns``, or ``None``; forget it and all older ones."""
        exact = self._waiting.pop(plant_ns, None)
        if not self._waiting:
            return exact
        due = [time for time in self._waiting if time < plant_ns]
        late = [self._waiting.pop(time) for time in due]
        candidates = late if exact is None else [exact, *late]
        return max(candidates, key=lambda plant_input: plant_input.tick, default=None)
