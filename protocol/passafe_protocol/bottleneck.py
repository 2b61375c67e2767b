"""The place where messages queue: it lets them through at a rate, or when a recorded network did."""

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from math import ceil
from typing import Final, TypeAlias

Schedule: TypeAlias = Callable[[int], int]
"""When a message that comes at a time is through, ns, if nothing else comes before; called once a message."""

_NS_PER_S: Final = 1e9


class Bottleneck:
    """A queue of bounded length in front of a schedule, first in, first out.

    Attributes:
        queue: Messages that wait at most, the one being let through among them.
        schedule: When the next one is through.
    """

    def __init__(self, queue: int, schedule: Schedule) -> None:
        self.queue = queue
        self.schedule = schedule
        self._waiting_ns: deque[int] = deque()

    def departure_ns(self, now_ns: int) -> int | None:
        """When a message that comes now is through; ``None`` if the queue is full."""
        waiting_ns = self._waiting_ns
        while waiting_ns and waiting_ns[0] <= now_ns:
            waiting_ns.popleft()
        if len(waiting_ns) >= self.queue:
            return None
        # A schedule that replaced another must not let a message overtake those that wait.
        departure_ns = max(self.schedule(now_ns), waiting_ns[-1] if waiting_ns else now_ns)
        waiting_ns.append(departure_ns)
        return departure_ns


class RateSchedule:
    """One message after the other, each taking 1/rate."""

    def __init__(self, rate_hz: float) -> None:
        self._interval_ns = ceil(_NS_PER_S / rate_hz)
        self._free_ns = 0

    def __call__(self, now_ns: int) -> int:
        """Return when a message that comes now is through."""
        self._free_ns = max(now_ns, self._free_ns) + self._interval_ns
        return self._free_ns


class TraceSchedule:
    """One message for each opportunity of a trace, as Mahimahi's mm-link has it: what is not used is gone.

    Time zero is the first message. The trace is repeated with its last time as the period.
    """

    def __init__(self, trace_s: tuple[float, ...]) -> None:
        self._times_ns = [round(time_s * _NS_PER_S) for time_s in trace_s]
        self._zero_ns: int | None = None
        self._next = 0  # number of the first opportunity not used, counted through all repetitions

    def __call__(self, now_ns: int) -> int:
        """Return the first opportunity at or after ``now_ns`` that is not used yet."""
        if self._zero_ns is None:
            self._zero_ns = now_ns
        times_ns, since_ns = self._times_ns, now_ns - self._zero_ns
        count, period_ns = len(times_ns), times_ns[-1]
        # The last time of one round is time zero of the next, so it is looked for in the previous_u one.
        rounds = max(0, -(-since_ns // period_ns) - 1)
        first = rounds * count + bisect_left(times_ns, since_ns - rounds * period_ns)
        at = max(first, self._next)
        self._next = at + 1
        return self._zero_ns + at // count * period_ns + times_ns[at % count]
