"""An injected link: a value that decides when, and whether, each message comes out.

It knows no clock and no threads. The reader puts in what the network delivered and asks what has arrived by
now.
"""

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush
from random import Random
from typing import Final, Generic, TypeVar

from protocol.errors import LinkSettingsError

T = TypeVar("T")

MAX_DELAY_S: Final = 10.0
"""Largest delay and largest jitter of a link; with the rate it bounds how much is under way."""

DROPPED: Final = "dropped"
"""Effect on a message that never comes out."""

_SEED_END: Final = 2**64
_NS_PER_S: Final = 1e9


@dataclass(frozen=True, kw_only=True, slots=True)
class LinkSettings:
    """Settings of one link.

    Attributes:
        delay_s: Constant part of the delay, s, in [0, ``MAX_DELAY_S``].
        jitter_s: Half width of the uniform part, s, in [0, ``MAX_DELAY_S``]: the delay of a message is
            max(0, delay_s + jitter_s·r), r uniform in [−1, 1). Messages may overtake one another.
        loss: Probability that a message is lost, independently of the others, in [0, 1].
        seed: Which random sequence decides, in [0, 2⁶⁴).

    Raises:
        LinkSettingsError: If one is outside its range.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    seed: int = 1

    def __post_init__(self) -> None:
        for field, largest in (("delay_s", MAX_DELAY_S), ("jitter_s", MAX_DELAY_S), ("loss", 1.0)):
            got = getattr(self, field)
            if isinstance(got, bool) or not isinstance(got, (int, float)) or not 0.0 <= got <= largest:
                raise LinkSettingsError(field, got, f"a number from 0 to {largest:g}")
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or not 0 <= self.seed < _SEED_END:
            raise LinkSettingsError("seed", self.seed, "an integer from 0 to 2⁶⁴ − 1")


class Link(Generic[T]):
    """One direction of a bad network: name, settings and times of ``put`` decide what comes out, and when.

    The generator is seeded by name and seed, so that links that share a seed lose different messages. It is
    drawn from twice for every message, needed or not, so that changing one setting leaves the randomness
    of the others as it was.

    Attributes:
        name: Name of the link, such as ``filter-to-plant``.
        settings: Settings in force for what is put in next.
    """

    def __init__(self, name: str, settings: LinkSettings) -> None:
        self.name = name
        self._under_way: list[tuple[int, int, T]] = []
        self._inserted = 0
        self._draw = self._generator(settings.seed)
        self.settings = settings
        self.reconfigure(settings)

    def reconfigure(self, settings: LinkSettings) -> None:
        """Put other settings in force.

        Messages under way keep their time. The random sequence goes on unless the seed is another one.
        """
        if settings.seed != self.settings.seed:
            self._draw = self._generator(settings.seed)
        self.settings = settings
        self._loss = settings.loss
        self._earliest_ns = (settings.delay_s - settings.jitter_s) * _NS_PER_S
        self._spread_ns = 2.0 * settings.jitter_s * _NS_PER_S

    def put(self, now_ns: int, item: T) -> str | None:
        """Let a message enter at ``now_ns``; returns ``DROPPED``, or ``None`` if it will come out."""
        lost = self._draw() < self._loss
        delay_ns = round(self._earliest_ns + self._spread_ns * self._draw())
        if lost:
            return DROPPED
        self._inserted += 1
        heappush(self._under_way, (now_ns + max(0, delay_ns), self._inserted, item))
        return None

    def take(self, now_ns: int) -> list[tuple[int, T]]:
        """What arrived by ``now_ns`` as (arrival_ns, item): by arrival, then in the order of ``put``."""
        arrived: list[tuple[int, T]] = []
        while self._under_way and self._under_way[0][0] <= now_ns:
            arrival_ns, _, item = heappop(self._under_way)
            arrived.append((arrival_ns, item))
        return arrived

    def _generator(self, seed: int) -> Callable[[], float]:
        return Random(f"{self.name}/{seed}").random  # noqa: S311  simulation, no secret
