"""An injected link: a value that decides when, and whether, each message comes out, and in which shape.

It knows no clock and no threads. The reader puts in what the network delivered and asks what has arrived by
now.
"""

from collections.abc import Callable
from heapq import heappop, heappush
from random import Random
from typing import Final, Generic, TypeVar

from passafe_protocol.bottleneck import Bottleneck, RateSchedule, Schedule, TraceSchedule
from passafe_protocol.correlated_uniform import CorrelatedUniform
from passafe_protocol.delay_distribution import delay_sampler
from passafe_protocol.gilbert_elliott import GilbertElliott
from passafe_protocol.link_effect import CORRUPTED, CUT, DUPLICATED, LOST, OVERFLOWED, UNHARMED, Effects, LinkCounts
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.outages import Outages

T = TypeVar("T")

Damage = Callable[[T, float], T]
"""What corruption makes of an item; the number in [0, 1) says where it strikes."""

_NS_PER_S: Final = 1e9
_COPY: Final = 0.5
"""A copy's place in the order of ``put`` is this far behind its message's."""


class Link(Generic[T]):
    """One direction of a bad network: name, settings and times of ``put`` decide what comes out, and when.

    Every effect draws from a random sequence of its own, seeded by link, seed and effect, a fixed number of times for
    each message while the effect is on, whatever the others do to the message. So links that share a seed lose
    different messages, and changing one setting leaves the randomness of the others as it was.

    Attributes:
        name: Name of the link, such as ``filter-to-plant``.
        settings: Settings in force for what is put in next.
        put: Let a message enter: ``put(now_ns, item)`` returns what is done to it, nothing if it is only delayed.
            ``now_ns`` never decreases. Chosen by the settings, so that a link does no work for what is switched off.
    """

    put: Callable[[int, T], Effects]

    def __init__(self, name: str, settings: LinkSettings, damage: Damage[T] | None = None) -> None:
        """Make a link with nothing under way.

        Args:
            name: Its name.
            settings: Its settings.
            damage: What corruption makes of an item; without it, a corrupted item stays as it is.
        """
        self.name = name
        self._damage = damage or _leave_as_is
        self._under_way: list[tuple[int, float, T]] = []
        self._entered = self._delivered = self._duplicated = self._corrupted = 0
        self._lost = self._overflowed = self._cut = 0
        self._in_order = False
        self._last_ns = 0  # arrival of the last one put in, while the order is kept
        self._generators: dict[str, Callable[[], float]] = {}
        self._bottleneck: Bottleneck | None = None
        self._outages = Outages(settings.outages_s)
        self.settings = settings
        self._start_sequences()
        self._apply(before=None)

    def reconfigure(self, settings: LinkSettings) -> None:
        """Put other settings in force.

        Messages under way keep their time. Random sequences go on unless the seed is another one; outages and a
        trace begin anew if they are others than before.
        """
        before, self.settings = self.settings, settings
        if settings.seed != before.seed:
            self._start_sequences()
        self._apply(before=before)

    @property
    def counts(self) -> LinkCounts:
        """What became of the messages so far."""
        return LinkCounts(
            entered=self._entered,
            delivered=self._delivered,
            dropped_loss=self._lost,
            dropped_queue=self._overflowed,
            dropped_outage=self._cut,
            duplicated=self._duplicated,
            corrupted=self._corrupted,
            in_flight=len(self._under_way),
        )

    def pass_on(self, number: int) -> None:
        """Count messages that were handed over without the link, because its settings do nothing."""
        self._entered += number
        self._delivered += number

    def take(self, now_ns: int) -> list[tuple[int, T]]:
        """What arrived by ``now_ns`` as (arrival_ns, item): by arrival, then in the order of ``put``."""
        in_flight = self._under_way
        arrived: list[tuple[int, T]] = []
        while in_flight and in_flight[0][0] <= now_ns:
            arrival_ns, _, item = heappop(in_flight)
            arrived.append((arrival_ns, item))
        self._delivered += len(arrived)
        return arrived

    def _put_on_time(self, now_ns: int, item: T) -> Effects:
        """Let a message enter a link with a constant delay and nothing else."""
        self._entered = number = self._entered + 1
        heappush(self._under_way, (now_ns + self._constant_ns, number, item))
        return UNHARMED

    def _put_plain(self, now_ns: int, item: T) -> Effects:
        """Let a message enter a link with uniform delays and independent loss at most."""
        self._entered = number = self._entered + 1
        delay_ns = round(self._base_ns + self._jitter_ns * (2.0 * self._draw_delay() - 1.0))
        if self._draw_loss() < self._loss:
            self._lost += 1
            return LOST
        heappush(self._under_way, (now_ns + delay_ns if delay_ns > 0 else now_ns, number, item))
        return UNHARMED

    def _put_through(self, now_ns: int, item: T) -> Effects:
        """Let a message enter a link with any effects."""
        self._entered = number = self._entered + 1
        cut = self._outages.cover(now_ns)
        lost = self._is_lost()
        delay_ns = self._delay_ns()
        strike = self._strike()
        copied = self._is_copied()
        if cut:
            self._cut += 1
            return CUT
        if lost:
            self._lost += 1
            return LOST
        departure_ns = now_ns if self._bottleneck is None else self._bottleneck.departure_ns(now_ns)
        if departure_ns is None:
            self._overflowed += 1
            return OVERFLOWED
        effects = self._send(departure_ns + delay_ns, number, item, strike)
        if copied:
            self._duplicated += 1
            delay_ns = self._copy_delay_ns()
            effects += DUPLICATED + self._send(departure_ns + delay_ns, number + _COPY, item, self._copy_strike())
        return effects

    def _send(self, arrival_ns: int, number: float, item: T, strike: float | None) -> Effects:
        if self._in_order:
            self._last_ns = arrival_ns = max(arrival_ns, self._last_ns)
        if strike is None:
            heappush(self._under_way, (arrival_ns, number, item))
            return UNHARMED
        self._corrupted += 1
        heappush(self._under_way, (arrival_ns, number, self._damage(item, strike)))
        return CORRUPTED

    def _start_sequences(self) -> None:
        self._generators = {}
        self._uniform = CorrelatedUniform(self._sequence("delay"))
        self._bursts = GilbertElliott(self._sequence("burst"), self.settings)

    def _sequence(self, effect: str) -> Callable[[], float]:
        """Random sequence of an effect: the one in use, or a new one."""
        if effect not in self._generators:
            generator = Random(f"{self.name}/{self.settings.seed}/{effect}")  # noqa: S311  simulation, no secret
            self._generators[effect] = generator.random
        return self._generators[effect]

    def _apply(self, *, before: LinkSettings | None) -> None:
        settings = self.settings
        if before is not None and settings.outages_s != before.outages_s:
            self._outages = Outages(settings.outages_s)
        self._apply_bottleneck(before)
        self._apply_delay()
        self._apply_fates()
        in_order = not settings.reorder
        if in_order and not self._in_order:
            self._last_ns = max((arrival_ns for arrival_ns, _, _ in self._under_way), default=0)
        self._in_order = in_order
        special = settings.has_bursts or settings.duplicate or settings.corrupt or settings.outages_s
        if in_order or special or self._bottleneck is not None:
            self.put = self._put_through
        elif settings.loss == 0.0 and settings.jitter_s == 0.0 and settings.distribution != "histogram":
            self.put = self._put_on_time
        elif settings.distribution == "uniform" and settings.correlation == 0.0:
            self.put = self._put_plain
        else:
            self.put = self._put_through

    def _apply_delay(self) -> None:
        settings, draw = self.settings, self._sequence("delay")
        self._constant_ns = round(settings.delay_s * _NS_PER_S)
        self._base_ns = settings.delay_s * _NS_PER_S
        self._jitter_ns = settings.jitter_s * _NS_PER_S
        self._draw_delay = draw if settings.jitter_s else _zero
        self._uniform.correlate(settings.correlation)
        self._delay_ns = delay_sampler(settings, self._uniform if settings.correlation else draw)
        self._copy_delay_ns = delay_sampler(settings, self._sequence("copy"))

    def _apply_fates(self) -> None:
        settings = self.settings
        self._loss = settings.loss
        self._draw_loss = self._sequence("loss") if settings.loss else _zero
        self._bursts.settings = settings
        self._is_lost = _chance(self._sequence("loss"), settings.loss)
        if settings.has_bursts:
            independent = self._is_lost
            self._is_lost = lambda: bool(int(self._bursts()) | int(independent()))  # both draw, whatever the other says
        self._is_copied = _chance(self._sequence("duplicate"), settings.duplicate)
        self._strike = _strikes(self._sequence("corrupt"), settings.corrupt)
        self._copy_strike = _strikes(self._sequence("copy"), settings.corrupt)

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


def _chance(draw: Callable[[], float], probability: float) -> Callable[[], bool]:
    """Function that tells whether something with this probability happens; it draws once, never if it cannot."""
    return (lambda: draw() < probability) if probability else _never


def _strikes(draw: Callable[[], float], probability: float) -> Callable[[], float | None]:
    """Function that says where in a message a bit flips, as a number in [0, 1); draws twice, never if none can."""
    if not probability:
        return _nowhere

    def strike() -> float | None:
        struck, place = draw() < probability, draw()
        return place if struck else None

    return strike


def _leave_as_is(item: T, _place: float) -> T:
    return item


def _zero() -> float:
    return 0.0


def _never() -> bool:
    return False


def _nowhere() -> float | None:
    return None
