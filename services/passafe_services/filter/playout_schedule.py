"""Which plant time a filter step works for."""

from typing import Final

from passafe_protocol.messages import PlantPhase, PlantState

_WAITING: Final = PlantPhase.WAITING

SLEW_STEPS: Final = 16
"""The schedule moves back by one period in so many steps, where the network got quicker."""


class EffectSchedule:
    """Gives every step the plant time at which its input is to take effect.

    The plant tells how long inputs took to come, the largest of the last second or two: plant time of arrival minus
    this filter's clock. Inputs are made for so much later, and the play-out time on top, which absorbs what is worse
    than that. Lost inputs that a later message repeats count as having come with that one, so loss is covered too. The
    schedule moves forward at once and back by and by.

    Attributes:
        moved: How often the schedule was moved forward since the start.
    """

    def __init__(self, *, period_ns: int, playout_ns: int, epoch: int) -> None:
        """Start without a schedule.

        Args:
            period_ns: Period of plant and filter, ns.
            playout_ns: What is kept in hand beyond the longest transit seen, ns, whole periods.
            epoch: This filter's session: transit times of another one say nothing.
        """
        self._period_ns = period_ns
        self._playout_ns = playout_ns
        self._epoch = epoch
        self._offset_ns = 0
        self._has_offset = False
        self._slack_steps = 0
        self.moved = 0

    def restart(self) -> None:
        """Forget the schedule: the plant is another one."""
        self._has_offset = False
        self._slack_steps = 0

    def effective_ns(self, now_ns: int, state: PlantState) -> int:
        """Return the plant time for which the step at ``now_ns`` makes an input.

        Args:
            now_ns: When the step is due, monotonic, ns; steps lie on a grid of the period.
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
        """Move the schedule to where the transit time puts it, and never to a time that the plant has passed."""
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
