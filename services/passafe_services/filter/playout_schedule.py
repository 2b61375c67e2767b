"""Play-out schedule: the plant time at which the input of each filter step takes effect."""

from typing import Final

from passafe_protocol.messages import PlantPhase, PlantState

_WAITING: Final = PlantPhase.WAITING

SLEW_STEPS: Final = 16
"""Steps in which the schedule moves back by one period after the network got faster."""


class PlayoutSchedule:
    """Assigns to every step the plant time at which its input takes effect.

    The plant reports the transit time of inputs, the maximum of the last 1 to 2 s: plant time of arrival minus this
    filter's clock. The effective time is that much later plus the play-out time, which absorbs longer transits. Lost
    inputs that a later message repeats count as arrived with it, so loss is covered too. The schedule moves forward at
    once and back slowly.

    Attributes:
        moved: Number of moves forward since the start.
    """

    def __init__(self, *, period_ns: int, playout_ns: int, epoch: int) -> None:
        """Start without a schedule.

        Args:
            period_ns: Period of plant and filter, ns.
            playout_ns: Margin beyond the longest transit time, ns, whole periods.
            epoch: Session of this filter; transit times of other sessions are ignored.
        """
        self._period_ns = period_ns
        self._playout_ns = playout_ns
        self._epoch = epoch
        self._offset_ns = 0
        self._has_offset = False
        self._slack_steps = 0
        self.moved = 0

    def restart(self) -> None:
        """Discard the schedule: the plant was restarted."""
        self._has_offset = False
        self._slack_steps = 0

    def effective_ns(self, now_ns: int, state: PlantState) -> int:
        """Return the effective plant time of the input of the step at ``now_ns``.

        Args:
            now_ns: Time at which the step is due, monotonic, ns; steps lie on a grid of the period.
            state: The newest plant state.
        """
        if not self._has_offset:
            first_ns = state.plant_ns
            if state.phase is not _WAITING:
                first_ns += self._period_ns + self._playout_ns
            self._offset_ns, self._has_offset = first_ns - now_ns, True
        if state.phase is not _WAITING:
            self._follow(now_ns, state)
        return now_ns + self._offset_ns

    def _follow(self, now_ns: int, state: PlantState) -> None:
        """Move the schedule to the reported transit time, never to a plant time that has passed."""
        period_ns, is_own = self._period_ns, state.input_epoch == self._epoch
        wanted_ns = state.plant_ns + period_ns - now_ns
        if is_own:
            wanted_ns = max(wanted_ns, state.input_transit_ns + self._playout_ns)
        missing_ns = wanted_ns - self._offset_ns
        if missing_ns > 0:
            self._offset_ns += -(-missing_ns // period_ns) * period_ns
            self._slack_steps = 0
            self.moved += 1
        elif is_own and missing_ns <= -2 * period_ns:
            self._slack_steps += 1
            if self._slack_steps == SLEW_STEPS:
                self._offset_ns -= period_ns
                self._slack_steps = 0
