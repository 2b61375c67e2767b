"""When each step of a loop at a fixed rate is due, and what became of the ones that were late."""


class Pace:
    """Absolute deadlines: start + k/rate. A late step does not shift the ones after it.

    A loop that fell behind by a period or more leaves out the steps that it cannot make any more and goes on
    with the newest one that is due. It never catches up by a burst.

    Args:
        start_ns: When the first step is due.
        rate_hz: Steps per second.

    Attributes:
        due_ns: When the next step is due.
        steps: Steps made.
        overruns: Steps that ended after the next was due.
        missed: Steps left out.
    """

    def __init__(self, start_ns: int, rate_hz: float) -> None:
        self._start_ns = start_ns
        self._period_ns = round(1e9 / rate_hz)
        self._index = 0
        self._worst_late_ns = 0
        self.due_ns = start_ns
        self.steps = 0
        self.overruns = 0
        self.missed = 0

    def begin(self, now_ns: int) -> int:
        """Begin a step at ``now_ns``, not before ``due_ns``; returns when this step was due."""
        late_ns = now_ns - self.due_ns
        self._worst_late_ns = max(self._worst_late_ns, late_ns)
        left_out = late_ns // self._period_ns
        if left_out > 0:
            self.missed += left_out
            self._advance(left_out)
        return self.due_ns

    def end(self, now_ns: int) -> None:
        """End the step at ``now_ns``."""
        self.steps += 1
        self._advance(1)
        if now_ns > self.due_ns:
            self.overruns += 1

    def take_worst_late_ns(self) -> int:
        """Worst lateness since the last call: how long after its time the first step due then began."""
        worst, self._worst_late_ns = self._worst_late_ns, 0
        return worst

    def _advance(self, steps: int) -> None:
        self._index += steps
        self.due_ns = self._start_ns + self._index * self._period_ns
