"""Which plant time a filter tick works for."""

from protocol.messages import PlantPhase, PlantState

_WAITING = PlantPhase.WAITING


class EffectSchedule:
    """Gives every tick the plant time at which its input takes effect, ahead of the plant by the play-out time.

    The filter's clock only counts ticks; how far ahead they are is told by the plant, which reports by how much the
    newest input came before its time. When one comes late, all later ones are moved forward.

    Attributes:
        moved: How often the schedule was moved forward since the start.
    """

    def __init__(self, *, period_ns: int, playout_ns: int) -> None:
        self._period_ns = period_ns
        self._playout_ns = playout_ns
        self._offset_ns: int | None = None
        self._first_tick_since_move = 0
        self.moved = 0

    def effective_ns(self, now_ns: int, state: PlantState, tick: int) -> int:
        """Return the plant time for which the tick at ``now_ns`` makes an input.

        Args:
            now_ns: When the tick is due, monotonic, ns; ticks lie on a grid of the period.
            state: The newest plant state.
            tick: Number of the tick.
        """
        if self._offset_ns is None:
            waiting = state.phase is _WAITING
            first_ns = state.plant_ns if waiting else self._ahead_of(state)
            self._offset_ns = first_ns - now_ns
        effective_ns = now_ns + self._offset_ns
        if state.phase is _WAITING:
            return effective_ns
        missing_ns = state.plant_ns + self._period_ns - effective_ns
        if state.input_slack_ns < 0 and state.received_tick >= self._first_tick_since_move:
            missing_ns = max(missing_ns, self._playout_ns - state.input_slack_ns)
        if missing_ns > 0:
            forward_ns = -(-missing_ns // self._period_ns) * self._period_ns
            self._offset_ns += forward_ns
            effective_ns += forward_ns
            self._first_tick_since_move = tick
            self.moved += 1
        return effective_ns

    def _ahead_of(self, state: PlantState) -> int:
        return state.plant_ns + self._period_ns + self._playout_ns
