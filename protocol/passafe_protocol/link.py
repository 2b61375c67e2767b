"""Injected link: emulates delay, loss, duplication, corruption, bandwidth and outages of one direction of a network.

A link has no clock and no threads: its reader puts in what the real network delivered and pops what has arrived by a
given time.
"""

from collections.abc import Callable
from heapq import heappop, heappush
from random import Random
from typing import Final, Generic, TypeVar

from passafe_protocol.bottleneck import Bottleneck, RateSchedule, Schedule, TraceSchedule
from passafe_protocol.correlated_uniform import CorrelatedUniform
from passafe_protocol.delay_distribution import delay_sampler
from passafe_protocol.delay_trace import DelayTrace
from passafe_protocol.gilbert_elliott import GilbertElliott
from passafe_protocol.link_draws import chance, corruption, zero
from passafe_protocol.link_effect import (
    CORRUPTED,
    DROPPED_BY_LOSS,
    DROPPED_BY_OUTAGE,
    DROPPED_BY_QUEUE,
    DUPLICATED,
    NO_EFFECT,
    Effects,
    LinkCounts,
)
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.network_path import NetworkPath
from passafe_protocol.networks import NETWORKS
from passafe_protocol.outages import Outages

T = TypeVar("T")

Damage = Callable[[T, float], T]
"""Returns the damaged item; the number in [0, 1) is the relative position of the damage."""

_NS_PER_S: Final = 1e9
_OF_NETWORK: Final = ("network", "delay_trace_s", "seed")
"""Settings with which another network begins."""

_COPY: Final = 0.5
"""Offset of a copy behind its message in the order of ``put``."""


class Link(Generic[T]):
    """One direction of an impaired network; its output is a function of name, settings and times of ``put`` alone.

    Every effect draws from a random generator of its own, seeded by link, seed and effect, a fixed number of times per
    message while the effect is enabled, whatever the other effects do to the message. Hence links that share a seed
    lose different messages, and changing one setting leaves the random draws of the others unchanged.

    Attributes:
        name: Name of the link, such as ``filter-to-plant``.
        settings: Settings in force for the messages put in next.
        put: Puts a message in: ``put(now_ns, item)`` returns the effects on it, none if it is only delayed. ``now_ns``
            never decreases. Selected by the settings, so that disabled effects cost nothing.
    """

    put: Callable[[int, T], Effects]
    _passage_ns: Callable[[int], int | None]

    def __init__(self, name: str, settings: LinkSettings, damage: Damage[T] | None = None) -> None:
        """Create a link with nothing in flight.

        Args:
            name: Its name.
            settings: Its settings.
            damage: Corrupts an item; without it, a corrupted item is delivered unchanged.
        """
        self.name = name
        self._damage = damage or _unchanged
        self._in_flight: list[tuple[int, float, T]] = []
        self._entered = self._delivered = self._duplicated = self._corrupted = 0
        self._loss_drops = self._queue_drops = self._outage_drops = 0
        self._in_order = False
        self._last_ns = 0  # arrival of the message put in last, while the order is kept
        self._generators: dict[str, Callable[[], float]] = {}
        self._bottleneck: Bottleneck | None = None
        self._outages = Outages(settings.outages_s)
        self.settings = settings
        self._start_generators()
        self._apply(before=None)

    def reconfigure(self, settings: LinkSettings) -> None:
        """Replace the settings.

        Messages in flight keep their arrival times. Random generators continue unless the seed changes; outages and a
        trace restart if they change.
        """
        before, self.settings = self.settings, settings
        if settings.seed != before.seed:
            self._start_generators()
        self._apply(before=before)

    @property
    def counts(self) -> LinkCounts:
        """Counts of messages since the start."""
        return LinkCounts(
            entered=self._entered,
            delivered=self._delivered,
            dropped_loss=self._loss_drops,
            dropped_queue=self._queue_drops,
            dropped_outage=self._outage_drops,
            duplicated=self._duplicated,
            corrupted=self._corrupted,
            in_flight=len(self._in_flight),
        )

    def count_passed(self, number: int) -> None:
        """Count messages that bypassed the link because its settings have no effect."""
        self._entered += number
        self._delivered += number

    def pop_arrived(self, now_ns: int) -> list[tuple[int, T]]:
        """Remove and return the items that arrived by ``now_ns`` as (arrival_ns, item), by arrival, then by ``put``."""
        in_flight = self._in_flight
        arrived: list[tuple[int, T]] = []
        while in_flight and in_flight[0][0] <= now_ns:
            arrival_ns, _, item = heappop(in_flight)
            arrived.append((arrival_ns, item))
        self._delivered += len(arrived)
        return arrived

    def _put_constant_delay(self, now_ns: int, item: T) -> Effects:
        """Put a message into a link that only has a constant delay."""
        self._entered = number = self._entered + 1
        heappush(self._in_flight, (now_ns + self._constant_ns, number, item))
        return NO_EFFECT

    def _put_uniform_delay(self, now_ns: int, item: T) -> Effects:
        """Put a message into a link that has at most uniform delays and independent loss."""
        self._entered = number = self._entered + 1
        delay_ns = round(self._base_ns + self._jitter_ns * (2.0 * self._draw_delay() - 1.0))
        if self._draw_loss() < self._loss:
            self._loss_drops += 1
            return DROPPED_BY_LOSS
        heappush(self._in_flight, (now_ns + delay_ns if delay_ns > 0 else now_ns, number, item))
        return NO_EFFECT

    def _put_any(self, now_ns: int, item: T) -> Effects:
        """Put a message into a link with any effects."""
        self._entered = number = self._entered + 1
        in_outage = self._outages.cover(now_ns)
        lost = self._is_lost()
        delay_ns = self._delay_ns()
        passage_ns = self._passage_ns(now_ns)
        strike = self._corrupt_at()
        copied = self._is_copied()
        if in_outage:
            self._outage_drops += 1
            return DROPPED_BY_OUTAGE
        if lost or passage_ns is None:
            self._loss_drops += 1
            return DROPPED_BY_LOSS
        departure_ns = now_ns if self._bottleneck is None else self._bottleneck.departure_ns(now_ns)
        if departure_ns is None:
            self._queue_drops += 1
            return DROPPED_BY_QUEUE
        effects = self._send(departure_ns + passage_ns + delay_ns, number, item, strike)
        if copied:
            self._duplicated += 1
            delay_ns = self._copy_delay_ns()
            effects += DUPLICATED + self._send(
                departure_ns + passage_ns + delay_ns, number + _COPY, item, self._copy_corrupt_at()
            )
        return effects

    def _send(self, arrival_ns: int, number: float, item: T, strike: float | None) -> Effects:
        if self._in_order:
            self._last_ns = arrival_ns = max(arrival_ns, self._last_ns)
        if strike is None:
            heappush(self._in_flight, (arrival_ns, number, item))
            return NO_EFFECT
        self._corrupted += 1
        heappush(self._in_flight, (arrival_ns, number, self._damage(item, strike)))
        return CORRUPTED

    def _start_generators(self) -> None:
        self._generators = {}
        self._uniform = CorrelatedUniform(self._sequence("delay"))
        self._bursts = GilbertElliott(self._sequence("burst"), self.settings)

    def _sequence(self, effect: str) -> Callable[[], float]:
        """Return the random generator of an effect, created at the first use."""
        if effect not in self._generators:
            generator = Random(f"{self.name}/{self.settings.seed}/{effect}")  # noqa: S311 - simulation, no secret
            self._generators[effect] = generator.random
        return self._generators[effect]

    def _apply(self, *, before: LinkSettings | None) -> None:
        settings = self.settings
        if before is not None and settings.outages_s != before.outages_s:
            self._outages = Outages(settings.outages_s)
        self._apply_bottleneck(before)
        self._apply_delay()
        self._apply_losses()
        self._apply_network(before)
        in_order = not settings.reorder
        if in_order and not self._in_order:
            self._last_ns = max((arrival_ns for arrival_ns, _, _ in self._in_flight), default=0)
        self._in_order = in_order
        special = (
            settings.network
            or settings.delay_trace_s
            or settings.has_bursts
            or settings.duplicate
            or settings.corrupt
            or settings.outages_s
        )
        if in_order or special or self._bottleneck is not None:
            self.put = self._put_any
        elif settings.loss == 0.0 and settings.jitter_s == 0.0 and settings.distribution != "histogram":
            self.put = self._put_constant_delay
        elif settings.distribution == "uniform" and settings.correlation == 0.0:
            self.put = self._put_uniform_delay
        else:
            self.put = self._put_any

    def _apply_delay(self) -> None:
        settings, draw = self.settings, self._sequence("delay")
        self._constant_ns = round(settings.delay_s * _NS_PER_S)
        self._base_ns = settings.delay_s * _NS_PER_S
        self._jitter_ns = settings.jitter_s * _NS_PER_S
        self._draw_delay = draw if settings.jitter_s else zero
        self._uniform.correlate(settings.correlation)
        self._delay_ns = delay_sampler(settings, self._uniform if settings.correlation else draw)
        self._copy_delay_ns = delay_sampler(settings, self._sequence("copy"))

    def _apply_losses(self) -> None:
        settings = self.settings
        self._loss = settings.loss
        self._draw_loss = self._sequence("loss") if settings.loss else zero
        self._bursts.settings = settings
        self._is_lost = chance(self._sequence("loss"), settings.loss)
        if settings.has_bursts:
            independent = self._is_lost
            self._is_lost = lambda: bool(int(self._bursts()) | int(independent()))  # both draw for every message
        self._is_copied = chance(self._sequence("duplicate"), settings.duplicate)
        self._corrupt_at = corruption(self._sequence("corrupt"), settings.corrupt)
        self._copy_corrupt_at = corruption(self._sequence("copy"), settings.corrupt)

    def _apply_network(self, before: LinkSettings | None) -> None:
        """Begin another network or trace of delays; one that did not change goes on."""
        settings = self.settings
        if before is not None and all(getattr(settings, name) == getattr(before, name) for name in _OF_NETWORK):
            return
        if settings.delay_trace_s:
            self._passage_ns = DelayTrace(settings.delay_trace_s).passage
        elif settings.network:
            draws = [self._sequence(f"{settings.network} {part}") for part in ("state", "reconfiguration", "message")]
            self._passage_ns = NetworkPath(NETWORKS[settings.network], *draws).passage
        else:
            self._passage_ns = _no_delay

    def _apply_bottleneck(self, before: LinkSettings | None) -> None:
        settings, bottleneck = self.settings, self._bottleneck
        limit = (settings.rate_hz, settings.trace_s)
        if not any(limit):
            self._bottleneck = None
        elif bottleneck is None:
            self._bottleneck = Bottleneck(settings.queue, _schedule(settings))
        else:
            bottleneck.queue = settings.queue
            if before is not None and limit != (before.rate_hz, before.trace_s):
                bottleneck.schedule = _schedule(settings)


def _schedule(settings: LinkSettings) -> Schedule:
    return TraceSchedule(settings.trace_s) if settings.trace_s else RateSchedule(settings.rate_hz)


def _unchanged(item: T, _position: float) -> T:
    return item


def _no_delay(_now_ns: int) -> int | None:
    return 0
