"""Schedule of a loop at a fixed rate: deadlines, overruns and skipped steps."""


class Pace:
    """Absolute deadlines: start + k/rate. A late step does not shift the following ones.

    A loop that is late by a period or more skips steps and continues with the newest one that is due. It never catches
    up in a burst.

    Args:
        start_ns: Time at which the first step is due.
        rate_hz: Steps per second.

    Attributes:
        period_ns: Time between two steps, ns.
        due_ns: Time at which the next step is due.
        steps: Steps executed.
        overruns: Steps that ended after the next was due.
        skipped: Steps skipped.
    """

    def __init__(self, start_ns: int, rate_hz: float) -> None:
        self._start_ns = start_ns
        self.period_ns = round(1e9 / rate_hz)
        self._index = 0
        self._max_lateness_ns = 0
        self.due_ns = start_ns
        self.steps = 0
        self.overruns = 0
        self.skipped = 0

    def begin(self, now_ns: int) -> int:
        """Begin a step at ``now_ns`` ≥ ``due_ns`` and return the time at which it was due."""
        late_ns = now_ns - self.due_ns
        self._max_lateness_ns = max(self._max_lateness_ns, late_ns)
        skipped = late_ns // self.period_ns
        if skipped > 0:
            self.skipped += skipped
            self._advance(skipped)
        return self.due_ns

    def end(self, now_ns: int) -> None:
        """End the step at ``now_ns``."""
        self.steps += 1
        self._advance(1)
        if now_ns > self.due_ns:
            self.overruns += 1

    def pop_max_lateness_ns(self) -> int:
        """Return the largest lateness of a step since the last call, and reset it."""
        largest, self._max_lateness_ns = self._max_lateness_ns, 0
        return largest

    def _advance(self, steps: int) -> None:
        self._index += steps
        self.due_ns = self._start_ns + self._index * self.period_ns
