"""Recorded delays of a network: what was sent at a time took this long, or was lost."""

from bisect import bisect_right
from math import isinf
from typing import Final

_NS_PER_S: Final = 1e9


class DelayTrace:
    """Delays by time of sending, repeated; time zero is the first message.

    A message shares the fate of the newest probe that was sent before it: losses between two probes cannot be known.
    The trace repeats with the last time plus the mean interval of the probes as its period.

    Args:
        delays_s: Time of sending and delay of each probe, s, the delay infinite for one that was lost; times begin with
            0 and do not decrease, the last one is above 0.
    """

    def __init__(self, delays_s: tuple[tuple[float, float], ...]) -> None:
        self._sent_ns = [round(sent_s * _NS_PER_S) for sent_s, _ in delays_s]
        self._delays_ns = [None if isinf(delay_s) else round(delay_s * _NS_PER_S) for _, delay_s in delays_s]
        self._period_ns = self._sent_ns[-1] + self._sent_ns[-1] // (len(delays_s) - 1)
        self._zero_ns: int | None = None

    def passage(self, now_ns: int) -> int | None:
        """Return the delay of a message that is sent now, ns; ``None`` if it is lost."""
        if self._zero_ns is None:
            self._zero_ns = now_ns
        into_ns = (now_ns - self._zero_ns) % self._period_ns
        return self._delays_ns[bisect_right(self._sent_ns, into_ns) - 1]
