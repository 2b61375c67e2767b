"""Adversary operators, which know everything that the filter knows and want the robot to fail.

They come in batches, one for each rollout; each has a generator of its own, so that what it asks for does not depend on
the others of its batch.
"""

from collections.abc import Callable, Sequence
from math import cos, pi
from typing import Final, TypeAlias

import numpy as np

from passafe.batch.batch_filter import BatchFilter
from passafe.numerics.workspace import Array

STRENGTH: Final = 20.0
"""Largest u_h in each axis, units of u."""

ALIKE: Final = 1e-5
"""Rows whose margins differ by no more are equally tight, units of u: the certificate hardly tells them apart."""

AdversaryBatch: TypeAlias = Callable[[float, BatchFilter | None], Array]
"""From plant time, s, and the filter's decisions before to u_h, shape (m, operators)."""


def piecewise_constant(rngs: Sequence[np.random.Generator], m: int, _elements: slice) -> AdversaryBatch:
    """Ask for something else about once a second."""
    until_s, u_h = np.zeros(len(rngs)), np.zeros((m, len(rngs)))

    def ask(t_s: float, _: BatchFilter | None) -> Array:
        for i in np.flatnonzero(t_s >= until_s).tolist():
            until_s[i] = t_s + rngs[i].exponential(1.0)
            u_h[:, i] = rngs[i].uniform(-STRENGTH, STRENGTH, m)
        return u_h

    return ask


def chirp(rngs: Sequence[np.random.Generator], m: int, _elements: slice) -> AdversaryBatch:
    """Swing ever faster, from 0.1 Hz to 50 Hz within 10 s."""
    drawn = [(rng.uniform(5.0, STRENGTH, m), rng.uniform(0, 2 * pi, m)) for rng in rngs]
    amplitude, phase = (np.array(each).T for each in zip(*drawn, strict=True))
    rate = np.log(500.0) / 10.0

    def ask(t_s: float, _: BatchFilter | None) -> Array:
        cycles = 0.1 * (np.exp(rate * t_s) - 1) / rate
        return np.asarray(amplitude * np.cos(2 * pi * cycles + phase))

    return ask


def bang_bang(rngs: Sequence[np.random.Generator], m: int, elements: slice) -> AdversaryBatch:
    """Throw the robot at the tightest row, let go, and again, with a period between 20 ms and 1 s."""
    periods_s = [float(np.exp(rng.uniform(np.log(0.02), 0.0))) for rng in rngs]

    def ask(t_s: float, decided: BatchFilter | None) -> Array:
        sign = [1.0 if cos(2 * pi * t_s / period_s) > 0 else -1.0 for period_s in periods_s]
        return np.array(sign) * STRENGTH * _against(decided, m, elements, _tightest_hard)

    return ask


def against_h(_rngs: Sequence[np.random.Generator], m: int, elements: slice) -> AdversaryBatch:
    """Push with full strength against the tightest hard row, always."""
    return lambda _t_s, decided: STRENGTH * _against(decided, m, elements, _tightest_hard)


def against_the_tank(_rngs: Sequence[np.random.Generator], m: int, elements: slice) -> AdversaryBatch:
    """Push with full strength where energy is drawn fastest."""
    return lambda _t_s, decided: STRENGTH * _against(decided, m, elements, _passivity)


ADVERSARIES: Final = {
    "piecewise-constant": piecewise_constant,
    "chirp": chirp,
    "bang-bang": bang_bang,
    "against-h": against_h,
    "against-the-tank": against_the_tank,
}
"""From each one's generator, the number m of axes and the batch elements of their decisions to an adversary batch."""

_Rows: TypeAlias = Callable[[BatchFilter, slice], Array | None]
"""From decisions to the gradient of a row of each element, shape (m, operators); ``None`` without such a row."""


def _against(decided: BatchFilter | None, m: int, elements: slice, row_of: _Rows) -> Array:
    """Directions of unit length in the maximum norm that lead into a row; the first axis where there is none."""
    first_axis = np.zeros((m, elements.stop - elements.start))
    first_axis[0] = 1.0
    row = None if decided is None else row_of(decided, elements)
    if row is None:
        return first_axis
    size = np.abs(row).max(axis=0)
    return np.where(size > 0, -row / np.where(size > 0, size, 1.0), first_axis)


def _tightest_hard(decided: BatchFilter, elements: slice) -> Array | None:
    hard = decided.hard
    if not hard:
        return None
    margins = decided.evaluation.margins[:hard, elements]
    tightest = (margins <= margins.min(axis=0) + ALIKE).argmax(axis=0)
    return decided.gradients[:, tightest, np.arange(elements.start, elements.stop)]


def _passivity(decided: BatchFilter, elements: slice) -> Array | None:
    return decided.gradients[:, -1, elements] if decided.constraints > decided.hard else None
