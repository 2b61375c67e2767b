"""Bottleneck of a link: a queue that is served at a rate, or at the delivery times of a recorded network."""

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from math import ceil
from typing import Final, TypeAlias

Schedule: TypeAlias = Callable[[int], int]
"""Maps the arrival time of a message to its departure time, ns, behind an empty queue; called once per message."""

_NS_PER_S: Final = 1e9


class Bottleneck:
    """First-in, first-out queue of bounded length in front of a schedule.

    Attributes:
        queue: Capacity, messages, the one in service included.
        schedule: Departure times.
    """

    def __init__(self, queue: int, schedule: Schedule) -> None:
        self.queue = queue
        self.schedule = schedule
        self._waiting_ns: deque[int] = deque()

    def departure_ns(self, now_ns: int) -> int | None:
        """Return the departure time of a message that arrives now, ns; ``None`` if the queue is full."""
        waiting_ns = self._waiting_ns
        while waiting_ns and waiting_ns[0] <= now_ns:
            waiting_ns.popleft()
        if len(waiting_ns) >= self.queue:
            return None
        # After a change of schedule a message must not overtake those in the queue.
        departure_ns = max(self.schedule(now_ns), waiting_ns[-1] if waiting_ns else now_ns)
        waiting_ns.append(departure_ns)
        return departure_ns


class RateSchedule:
    """Serves one message after the other, each in 1/rate."""

    def __init__(self, rate_hz: float) -> None:
        self._interval_ns = ceil(_NS_PER_S / rate_hz)
        self._free_ns = 0

    def __call__(self, now_ns: int) -> int:
        """Return the departure time of a message that arrives now, ns."""
        self._free_ns = max(now_ns, self._free_ns) + self._interval_ns
        return self._free_ns


class TraceSchedule:
    """Serves one message per delivery opportunity of a trace, like Mahimahi's mm-link: unused opportunities are lost.

    Time zero is the first message. The trace is repeated with its last time as the period.
    """

    def __init__(self, trace_s: tuple[float, ...]) -> None:
        self._times_ns = [round(time_s * _NS_PER_S) for time_s in trace_s]
        self._zero_ns: int | None = None
        self._next = 0  # number of the first unused opportunity, counted across repetitions

    def __call__(self, now_ns: int) -> int:
        """Return the time of the first unused opportunity at or after ``now_ns``, ns."""
        if self._zero_ns is None:
            self._zero_ns = now_ns
        times_ns, since_ns = self._times_ns, now_ns - self._zero_ns
        count, period_ns = len(times_ns), times_ns[-1]
        # The last time of one repetition is time zero of the next; it belongs to the former.
        rounds = max(0, -(-since_ns // period_ns) - 1)
        first = rounds * count + bisect_left(times_ns, since_ns - rounds * period_ns)
        at = max(first, self._next)
        self._next = at + 1
        return self._zero_ns + at // count * period_ns + times_ns[at % count]
