"""Estimators that compete in ``human_input.py``: each for one axis of u_h and its rate from samples as they arrive.

All but the first are continued beyond the newest sample by the same rule as ours: its rate for ``horizon_s``, then
fading to zero over ``fade_s``. An overtaken sample is put where it belongs by those that can.
"""

from bisect import insort
from math import inf, pi
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from passafe.human_input import HandModel, HumanInputEstimator

STEP: Final = 2.0 / 64
"""Quantisation of the samples: 1/64 of the range from -1 to 1."""


class Contender(Protocol):
    """An estimator of one axis."""

    def add(self, time_s: float, value: float) -> None:
        """Take in a sample asked for at ``time_s``."""
        ...

    def at(self, time_s: float) -> tuple[float, float]:
        """Return u_h and its rate at a time."""
        ...


class Reach(NamedTuple):
    """Time beyond the newest sample for which its rate is used."""

    horizon_s: float
    fade_s: float

    def continued(self, ahead_s: float, u: float, rate: float, curvature: float = 0.0) -> tuple[float, float]:
        """Return value and rate ``ahead_s`` after both were as given."""
        near_s = min(max(ahead_s, 0.0), self.horizon_s)
        u, rate = u + near_s * (rate + 0.5 * near_s * curvature), rate + near_s * curvature
        beyond_s = min(max(ahead_s - self.horizon_s, 0.0), self.fade_s)
        left = 1.0 - beyond_s / self.fade_s
        return u + 0.5 * beyond_s * (1.0 + left) * rate, rate * left


class Hold:
    """The newest sample, and no rate: what ``as-sent`` does with a device that sends none."""

    def __init__(self) -> None:
        self._newest = (-inf, 0.0)

    def add(self, time_s: float, value: float) -> None:
        """Keep it if it is newer."""
        self._newest = max(self._newest, (time_s, value))

    def at(self, time_s: float) -> tuple[float, float]:  # noqa: ARG002 - the same at all times
        """Return it."""
        return self._newest[1], 0.0


class FiniteDifference:
    """The newest sample and the slope between the newest two."""

    def __init__(self, horizon_s: float, fade_s: float) -> None:
        self._reach = Reach(horizon_s, fade_s)
        self._samples: list[tuple[float, float]] = []

    def add(self, time_s: float, value: float) -> None:
        """Keep the newest two."""
        insort(self._samples, (time_s, value))
        del self._samples[:-2]

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the newest, continued."""
        if len(self._samples) < 2:
            return (self._samples[-1][1] if self._samples else 0.0), 0.0
        (t_0, u_0), (t_1, u_1) = self._samples
        return self._reach.continued(time_s - t_1, u_1, (u_1 - u_0) / (t_1 - t_0))


class LocalRegression:
    """Least squares of a polynomial over the samples of the last ``window_s``, at least degree + 1 of them."""

    def __init__(self, degree: int, window_s: float, horizon_s: float, fade_s: float) -> None:
        self._degree, self._window_s, self._reach = degree, window_s, Reach(horizon_s, fade_s)
        self._samples: list[tuple[float, float]] = []
        self._fit: tuple[float, ...] = (0.0, 0.0, 0.0)

    def add(self, time_s: float, value: float) -> None:
        """Keep the window and fit anew."""
        insort(self._samples, (time_s, value))
        newest_s, least = self._samples[-1][0], self._degree + 1
        while len(self._samples) > least and self._samples[0][0] < newest_s - self._window_s:
            del self._samples[0]
        degree = min(self._degree, len(self._samples) - 1)
        t, u = np.array(self._samples).T
        basis = np.vander(t - newest_s, degree + 1, increasing=True)
        fit = np.linalg.lstsq(basis, u, rcond=None)[0].tolist()
        self._fit = (*fit, 0.0, 0.0)[:3]

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the polynomial at the newest sample, continued."""
        if not self._samples:
            return 0.0, 0.0
        u, rate, half_curvature = self._fit
        return self._reach.continued(time_s - self._samples[-1][0], u, rate, 2.0 * half_curvature)


class OneEuro:
    """Casiez, Roussel & Vogel 2012: a low-pass whose cut-off rises with the speed; overtaken samples are ignored."""

    def __init__(self, cutoff_hz: float, beta: float, rate_cutoff_hz: float, horizon_s: float, fade_s: float) -> None:
        self._cutoff_hz, self._beta, self._rate_cutoff_hz = cutoff_hz, beta, rate_cutoff_hz
        self._reach = Reach(horizon_s, fade_s)
        self._time_s, self._sample, self._u, self._rate = -inf, 0.0, 0.0, 0.0

    def add(self, time_s: float, value: float) -> None:
        """Filter the slope, then the value."""
        dt = time_s - self._time_s
        if dt <= 0.0:
            return
        if dt < inf:
            self._rate += _share(self._rate_cutoff_hz, dt) * ((value - self._sample) / dt - self._rate)
            self._u += _share(self._cutoff_hz + self._beta * abs(self._rate), dt) * (value - self._u)
        else:
            self._u = value
        self._time_s, self._sample = time_s, value

    def at(self, time_s: float) -> tuple[float, float]:
        """Return both, continued."""
        return self._reach.continued(time_s - self._time_s, self._u, self._rate)


def _share(cutoff_hz: float, dt_s: float) -> float:
    return 1.0 / (1.0 + 1.0 / (2.0 * pi * cutoff_hz * dt_s))


class WhiteJerk:
    """Kalman filter of value, rate and second derivative, the last a random walk; overtaken samples are ignored."""

    def __init__(self, agility: float, resolution: float, horizon_s: float, fade_s: float) -> None:
        self._S, self._R, self._reach = agility**2, resolution**2 / 12.0, Reach(horizon_s, fade_s)
        self._time_s, self._x, self._P = -inf, np.zeros(3), np.diag([self._R, self._S, self._S])

    def add(self, time_s: float, value: float) -> None:
        """Predict exactly over dt and update."""
        dt = time_s - self._time_s
        if dt <= 0.0:
            return
        self._time_s = time_s
        if dt == inf:
            self._x[0] = value
            return
        F = np.array([[1.0, dt, dt**2 / 2], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])
        Q = np.array(
            [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
        )
        x, P = F @ self._x, F @ self._P @ F.T + self._S * Q
        gain = P[:, 0] / (P[0, 0] + self._R)
        self._x, self._P = x + gain * (value - x[0]), P - np.outer(gain, P[0])

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the newest belief, continued."""
        return self._reach.continued(time_s - self._time_s, *self._x.tolist())


class Ours:
    """``HumanInputEstimator``: white acceleration; with ``keeps`` false, overtaken samples are ignored."""

    def __init__(self, keeps: bool = True, **model: float) -> None:
        self._estimator = HumanInputEstimator(HandModel(**model), 1)
        self._keeps, self._newest_s = keeps, -inf

    def add(self, time_s: float, value: float) -> None:
        """Hand it on."""
        if self._keeps or time_s > self._newest_s:
            self._newest_s = max(self._newest_s, time_s)
            self._estimator.add(time_s, (value,))

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the axis."""
        (u_h,), (rate,) = self._estimator.at(time_s)
        return u_h, rate


class Entry(NamedTuple):
    """A contender with the settings to choose from; every combination is tried, ``chosen`` is the best of them."""

    make: Any
    choices: dict[str, tuple[Any, ...]]
    chosen: dict[str, Any]


_REACH: Final = {"horizon_s": (0.0, 0.02, 0.05), "fade_s": (0.1, 0.2, 0.3, 0.5)}
_CHOSEN: Final = {"horizon_s": 0.0, "fade_s": 0.2}

ENTRIES: Final[dict[str, Entry]] = {
    "hold, rate 0": Entry(Hold, {}, {}),
    "finite difference": Entry(FiniteDifference, _REACH, _CHOSEN),
    "one-Euro": Entry(
        OneEuro,
        {"cutoff_hz": (10.0, 30.0), "beta": (5.0, 20.0), "rate_cutoff_hz": (4.0, 8.0, 16.0)} | _REACH,
        {"cutoff_hz": 30.0, "beta": 20.0, "rate_cutoff_hz": 16.0} | _CHOSEN,
    ),
    "local line": Entry(
        LocalRegression,
        {"degree": (1,), "window_s": (0.02, 0.03, 0.05, 0.08)} | _REACH,
        {"degree": 1, "window_s": 0.03} | _CHOSEN,
    ),
    "local parabola": Entry(
        LocalRegression,
        {"degree": (2,), "window_s": (0.04, 0.06, 0.08, 0.12)} | _REACH,
        {"degree": 2, "window_s": 0.08} | _CHOSEN,
    ),
    "Kalman, white jerk": Entry(
        WhiteJerk,
        {"resolution": (STEP,), "agility": (75.0, 150.0, 300.0)} | _REACH,
        {"resolution": STEP, "agility": 150.0} | _CHOSEN,
    ),
    "passafe, overtaken ignored": Entry(
        Ours,
        {"keeps": (False,), "resolution": (STEP,), "agility": (5.0, 10.0, 15.0, 20.0)} | _REACH,
        {"keeps": False, "resolution": STEP, "agility": 10.0} | _CHOSEN,
    ),
    "passafe": Entry(
        Ours,
        {"resolution": (STEP,), "agility": (5.0, 10.0, 15.0, 20.0)} | _REACH,
        {"resolution": STEP, "agility": 10.0} | _CHOSEN,
    ),
}
