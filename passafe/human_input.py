"""The operator's input between and after samples: u_h and its rate, estimated with a model of the hand.

Each axis is a Kalman filter whose rate is a random walk (white acceleration), discretised exactly for the time
between two samples (Bar-Shalom, Li & Kirubarajan 2001, section 6.2). Decision 0006 says why this one.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Final, NamedTuple

from msgspec import Struct

from passafe.errors import DesignError

KEPT: Final = 64
"""Samples kept, so that a late one can be inserted in order; one older than all of them is ignored."""

START_S: Final = 1.0
"""The first sample's rate is as uncertain as a rate known exactly this long before."""

GAP_S: Final = 1.0
"""Samples this far apart are unrelated: the later one restarts the estimate."""

LARGEST: Final = 1e100
"""Samples with a larger number are ignored, so that no product here leaves what a float holds."""

NEAR_S: Final = 0.004
"""An overtaken sample nearer than this to an accepted one is ignored: it adds little information, and replaying the
later samples would cost more than the rest of a tick where commands come every millisecond."""

PROPORTIONS: Final = (1e-3, 1e5)
"""Least and largest agility/resolution. Above, p_rr − k_r·p_ur cancels so far that a variance could become negative."""


@dataclass(frozen=True, kw_only=True, slots=True)
class HandModel:
    """Model of the operator's input: its motion, its resolution, and how far ahead it is extrapolated.

    Only the ratio ``agility``/``resolution`` decides how much weight a sample gets.

    Attributes:
        agility: √S, S the spectral density of the input's second derivative, units of u per s^1.5: over a time t
            the rate changes by about √(S·t).
        resolution: Step q of the samples' quantisation, units of u; it counts as white noise of variance q²/12.
        horizon_s: Time after the newest sample for which its rate is kept, s.
        fade_s: Time in which the rate then falls to zero, linearly, s.
    """

    agility: float
    resolution: float
    horizon_s: float
    fade_s: float

    def __post_init__(self) -> None:
        """Refuse values for which the recursion is useless or overflows."""
        for name, low, high in (
            ("agility", 1e-9, 1e9),
            ("resolution", 1e-9, 1e9),
            ("horizon_s", 0.0, 1.0),
            ("fade_s", 1e-3, 1.0),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise DesignError(f"hand model {name}", value, f"from {low:g} to {high:g}")
        least, most = PROPORTIONS
        if not least <= self.agility / self.resolution <= most:
            allowed = f"agility from {least:g} to {most:g} times resolution"
            raise DesignError("hand model agility", f"{self.agility} with resolution {self.resolution}", allowed)


class HumanInput(NamedTuple):
    """The operator's input at one time.

    Attributes:
        u_h: m numbers, units of u.
        u_h_rate: Its time derivative, m numbers, units of u per second; zero where no sample counts.
    """

    u_h: tuple[float, ...]
    u_h_rate: tuple[float, ...]


class _Belief(Struct, frozen=True, gc=False):
    """The estimate just after a sample: means of every axis, and the covariance that all share, over q²/12."""

    time_s: float
    sample: tuple[float, ...]
    value: tuple[float, ...]
    rate: tuple[float, ...]
    p_uu: float
    p_ur: float
    p_rr: float


class HumanInputEstimator:
    """Estimates u_h and u̇_h of m axes from samples that come irregularly, late, overtaken or twice.

    The result depends on the samples and their times alone, not on the order in which they came, as long as they are
    ``NEAR_S`` apart and each is newer than the oldest one kept when it comes. It is made of sums, products and
    quotients only: the same to the last bit on every processor.
    """

    def __init__(self, model: HandModel, inputs: int) -> None:
        """Start without samples.

        Args:
            model: The model of the operator's hand.
            inputs: m.

        Raises:
            DesignError: Without an input.
        """
        if inputs < 1:
            raise DesignError("inputs of the human-input estimator", inputs, "1 or more")
        self._m = inputs
        self._intensity = 12.0 * (model.agility / model.resolution) ** 2
        self._horizon_s, self._fade_s = model.horizon_s, model.fade_s
        self._zero = HumanInput((0.0,) * inputs, (0.0,) * inputs)
        self._beliefs: deque[_Belief] = deque(maxlen=KEPT)

    def restart(self) -> None:
        """Forget all samples: until the next one u_h is zero, and that one leaves the rate unknown."""
        self._beliefs.clear()

    def add(self, time_s: float, sample: Sequence[float]) -> bool:
        """Add a sample of the operator's input.

        Args:
            time_s: Time of the sample, s, on the same clock as ``at``'s.
            sample: m numbers, units of u.

        Returns:
            Whether it counts: not one of the wrong length, with a number that is not finite or beyond ``LARGEST``,
            overtaken and within ``NEAR_S`` of one that counts (a repeated one is), or older than everything kept.
        """
        if len(sample) != self._m or not isfinite(time_s):
            return False
        for number in sample:
            if not -LARGEST <= number <= LARGEST:
                return False
        beliefs = self._beliefs
        if beliefs and time_s <= beliefs[-1].time_s:
            return self._insert(time_s, tuple(sample))
        beliefs.append(self._after(beliefs[-1] if beliefs else None, time_s, tuple(sample)))
        return True

    def at(self, time_s: float) -> HumanInput:
        """Return the input at a time: the newest sample's belief, continued.

        u_h = u + r·(a + b − b²/2F), u̇_h = r·(1 − b/F), with a the time since the newest sample up to the horizon, b
        what is beyond it up to F = ``fade_s``. A time before the newest sample counts as that sample's.

        Args:
            time_s: The time asked for, s.

        Returns:
            Finite numbers, whatever the time; zero before the first sample.
        """
        if not self._beliefs:
            return self._zero
        newest = self._beliefs[-1]
        ahead_s = time_s - newest.time_s
        if not ahead_s > 0.0:
            return HumanInput(newest.value, newest.rate)
        reach_s, left = ahead_s, 1.0
        if ahead_s > self._horizon_s:
            beyond_s = min(ahead_s - self._horizon_s, self._fade_s)
            left = 1.0 - beyond_s / self._fade_s
            reach_s = self._horizon_s + 0.5 * beyond_s * (1.0 + left)
        u_h, u_h_rate = [], []
        for u, r in zip(newest.value, newest.rate, strict=True):  # one plain loop: two comprehensions cost half more
            u_h.append(u + reach_s * r)
            u_h_rate.append(left * r)
        return HumanInput(tuple(u_h), tuple(u_h_rate))

    def _insert(self, time_s: float, sample: tuple[float, ...]) -> bool:
        """Insert an overtaken sample in order and replay the later ones."""
        beliefs, later = self._beliefs, []
        for known in reversed(beliefs):
            if abs(known.time_s - time_s) < NEAR_S:
                return False
            if known.time_s < time_s:
                break
            later.append(known)
        else:
            return False
        for _ in later:
            beliefs.pop()
        beliefs.append(self._after(beliefs[-1], time_s, sample))
        for known in reversed(later):
            beliefs.append(self._after(beliefs[-1], known.time_s, known.sample))
        return True

    def _after(self, before: _Belief | None, time_s: float, sample: tuple[float, ...]) -> _Belief:
        """Return the belief after one more sample: prediction over dt with exact process noise, then the update."""
        S = self._intensity
        if before is None or time_s - before.time_s > GAP_S:
            return _Belief(time_s, sample, sample, self._zero.u_h_rate, 1.0, 0.0, S * START_S)
        dt = time_s - before.time_s
        noise = S * dt
        p_uu = before.p_uu + dt * (before.p_ur + before.p_ur + dt * (before.p_rr + noise / 3.0))
        p_ur = before.p_ur + dt * (before.p_rr + 0.5 * noise)
        p_rr = before.p_rr + noise
        share = 1.0 / (p_uu + 1.0)
        k_u, k_r = p_uu * share, p_ur * share
        value, rate = [], []
        for u, r, z in zip(before.value, before.rate, sample, strict=True):
            ahead = u + dt * r
            missed = z - ahead
            value.append(ahead + k_u * missed)
            rate.append(r + k_r * missed)
        return _Belief(time_s, sample, tuple(value), tuple(rate), k_u, k_r, p_rr - k_r * p_ur)
