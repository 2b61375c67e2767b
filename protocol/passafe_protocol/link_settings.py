"""Settings of one injected link and their ranges."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from typing import Final, TypeAlias

from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.networks import NETWORKS

Span: TypeAlias = tuple[float, float]

MAX_DELAY_S: Final = 10.0
"""Largest delay and largest jitter of a link."""

MAX_QUEUE: Final = 1_000_000
MIN_QUANTILES: Final = 2
MAX_QUANTILES: Final = 64
MAX_OUTAGES: Final = 64
MAX_OPPORTUNITIES: Final = 1_000_000
MAX_SCHEDULE_S: Final = 1e6
MIN_DELAYS: Final = 2

LEAST_RATE_HZ: Final = 1e-3

DISTRIBUTIONS: Final = ("uniform", "normal", "pareto", "pareto-normal", "histogram")

RANGES: Final[dict[str, Span]] = {
    "delay_s": (0.0, MAX_DELAY_S),
    "jitter_s": (0.0, MAX_DELAY_S),
    "correlation": (0.0, 0.9999),
    "loss": (0.0, 1.0),
    "burst_enter": (0.0, 1.0),
    "burst_leave": (0.0, 1.0),
    "burst_loss_good": (0.0, 1.0),
    "burst_loss_bad": (0.0, 1.0),
    "duplicate": (0.0, 1.0),
    "corrupt": (0.0, 1.0),
    "rate_hz": (0.0, 1e6),
}
"""Smallest and largest value of each numeric setting."""

_SEED_END: Final = 2**64


@dataclass(frozen=True, kw_only=True, slots=True)
class LinkSettings:
    """Settings of one link. Probabilities are per message; schedules start with a message.

    Effects apply in this order: outage, loss, bottleneck (rate or trace), delay, duplication, corruption.

    Attributes:
        delay_s: Constant part of the delay, s, in [0, ``MAX_DELAY_S``].
        jitter_s: Scale of the random part, s, in [0, ``MAX_DELAY_S``]: half width where ``distribution`` is
            ``uniform``, standard deviation elsewhere. See ``passafe_protocol.delay_distribution``.
        distribution: Distribution of the random part, one of ``DISTRIBUTIONS``.
        quantiles_s: For ``histogram``: delays exceeded with probability 1, …, 0 in equal steps, s, added to
            ``delay_s``; ``jitter_s`` must be 0.
        correlation: Rank correlation of the delays of successive messages, in [0, 0.9999]. See
            ``passafe_protocol.correlated_uniform``.
        reorder: Whether messages may be reordered. If not, a message waits for those put in before it.
        loss: Probability of an independent loss.
        burst_enter: p of the Gilbert–Elliott model, good to bad. See ``passafe_protocol.gilbert_elliott``.
        burst_leave: r, bad to good.
        burst_loss_good: 1 − k, loss probability in the good state.
        burst_loss_bad: 1 − h, loss probability in the bad state.
        duplicate: Probability that a copy is delivered too, with a delay of its own.
        corrupt: Probability that a message or a copy is delivered with one bit flipped.
        rate_hz: Rate of the bottleneck, messages per second; 0: no limit.
        queue: Capacity of the queue at the bottleneck, messages; further ones are dropped.
        outages_s: Intervals (start, end) in which messages are dropped, ordered and disjoint, s from the first message
            put in under these outages.
        trace_s: Instead of ``rate_hz``: ordered times at which the bottleneck passes one message, s from the first
            message put in under this trace; repeated with the last one as the period.
        delay_trace_s: Instead of ``network``: recorded delays, as pairs of the time of sending and the delay, s, the
            latter infinite for a lost message. See ``passafe_protocol.delay_trace``.
        network: Name of a model of a real network, one of ``passafe_protocol.networks``, whose delays and losses come
            on top of the other effects; empty: none.
        seed: Seed of the random generators, in [0, 2⁶⁴).

    Raises:
        LinkSettingsError: A setting is outside its range, or two settings contradict each other.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    distribution: str = "uniform"
    quantiles_s: tuple[float, ...] = ()
    correlation: float = 0.0
    reorder: bool = True
    loss: float = 0.0
    burst_enter: float = 0.0
    burst_leave: float = 1.0
    burst_loss_good: float = 0.0
    burst_loss_bad: float = 1.0
    duplicate: float = 0.0
    corrupt: float = 0.0
    rate_hz: float = 0.0
    queue: int = 1000
    outages_s: tuple[Span, ...] = ()
    trace_s: tuple[float, ...] = ()
    delay_trace_s: tuple[Span, ...] = ()
    network: str = ""
    seed: int = 1

    def __post_init__(self) -> None:
        for field, (least, largest) in RANGES.items():
            got = getattr(self, field)
            if not _is_number(got) or not least <= got <= largest:
                raise LinkSettingsError(field, got, f"a number from {least:g} to {largest:g}")
        if 0.0 < self.rate_hz < LEAST_RATE_HZ:
            raise LinkSettingsError("rate_hz", self.rate_hz, f"0 (no limit), or at least {LEAST_RATE_HZ:g}")
        if self.distribution not in DISTRIBUTIONS:
            raise LinkSettingsError("distribution", self.distribution, ", ".join(DISTRIBUTIONS))
        if not isinstance(self.reorder, bool):
            raise LinkSettingsError("reorder", self.reorder, "true or false")
        if not _is_integer(self.queue) or not 1 <= self.queue <= MAX_QUEUE:
            raise LinkSettingsError("queue", self.queue, f"an integer from 1 to {MAX_QUEUE}")
        if not _is_integer(self.seed) or not 0 <= self.seed < _SEED_END:
            raise LinkSettingsError("seed", self.seed, "an integer from 0 to 2⁶⁴ − 1")
        self._check_quantiles()
        self._check_outages()
        self._check_trace()
        self._check_network()

    @property
    def has_bursts(self) -> bool:
        """True if the Gilbert–Elliott model can lose a message."""
        return self.burst_loss_good > 0.0 or (self.burst_enter > 0.0 and self.burst_loss_bad > 0.0)

    def _check_quantiles(self) -> None:
        got = self.quantiles_s
        if self.distribution != "histogram":
            if got:
                raise LinkSettingsError("quantiles_s", got, "none unless the distribution is histogram")
            return
        if not MIN_QUANTILES <= len(got) <= MAX_QUANTILES or not _is_rising(got, MAX_DELAY_S):
            allowed = f"{MIN_QUANTILES} to {MAX_QUANTILES} non-decreasing numbers from 0 to {MAX_DELAY_S:g}"
            raise LinkSettingsError("quantiles_s", got, allowed)
        if self.jitter_s:
            raise LinkSettingsError("jitter_s", self.jitter_s, "0 if the distribution is histogram")

    def _check_outages(self) -> None:
        edges = [edge for span in self.outages_s for edge in span]
        paired = all(len(span) == 2 for span in self.outages_s)  # noqa: PLR2004 - start and end
        rising = _is_rising(edges, MAX_SCHEDULE_S) and all(start < end for start, end in pairwise(edges))
        if len(self.outages_s) > MAX_OUTAGES or not paired or not rising:
            allowed = f"at most {MAX_OUTAGES} pairs (start, end) of times from 0 to {MAX_SCHEDULE_S:g}, all increasing"
            raise LinkSettingsError("outages_s", self.outages_s, allowed)

    def _check_trace(self) -> None:
        got = self.trace_s
        if not got:
            return
        if len(got) > MAX_OPPORTUNITIES or not _is_rising(got, MAX_SCHEDULE_S) or got[-1] <= 0:
            allowed = f"at most {MAX_OPPORTUNITIES} non-decreasing times from 0 to {MAX_SCHEDULE_S:g}"
            raise LinkSettingsError("trace_s", got, f"{allowed}, the last one above 0")
        if self.rate_hz:
            raise LinkSettingsError("rate_hz", self.rate_hz, "0 if there is a trace")

    def _check_network(self) -> None:
        if self.network and self.network not in NETWORKS:
            raise LinkSettingsError("network", self.network, f"none, or one of {', '.join(NETWORKS)}")
        got = self.delay_trace_s
        if not got:
            return
        times = [pair[0] for pair in got]
        enough = MIN_DELAYS <= len(got) <= MAX_OPPORTUNITIES
        if not enough or times[0] or times[-1] <= 0 or not _is_rising(times, MAX_SCHEDULE_S):
            allowed = (
                f"{MIN_DELAYS} to {MAX_OPPORTUNITIES} non-decreasing times of sending from 0 to {MAX_SCHEDULE_S:g}"
            )
            raise LinkSettingsError("delay_trace_s", got, f"{allowed}, the first one 0, the last one above 0")
        if not all(0.0 <= delay_s <= MAX_DELAY_S or delay_s == inf for _, delay_s in got):
            raise LinkSettingsError("delay_trace_s", got, f"delays from 0 to {MAX_DELAY_S:g} s, or infinite ones")
        if self.network:
            raise LinkSettingsError("network", self.network, "none if there is a trace of delays")


def _is_number(got: object) -> bool:
    return isinstance(got, (int, float)) and not isinstance(got, bool)


def _is_integer(got: object) -> bool:
    return isinstance(got, int) and not isinstance(got, bool)


def _is_rising(got: Sequence[object], largest: float) -> bool:
    """Check that these are non-decreasing numbers from 0 to ``largest``."""
    numbers = [each for each in got if isinstance(each, (int, float)) and not isinstance(each, bool) and isfinite(each)]
    in_order = all(a <= b for a, b in pairwise(numbers))
    return len(numbers) == len(got) and in_order and all(0.0 <= each <= largest for each in numbers)
