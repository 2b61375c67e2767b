"""Operators who want the robot to fail: what they ask for next, knowing everything that the filter knows."""

from collections.abc import Callable
from math import cos, pi
from typing import Final, TypeAlias

import numpy as np

from passafe.decision import Decision
from passafe.workspace import Array

STRENGTH: Final = 20.0
"""Largest u_h in each axis, units of u."""

Adversary: TypeAlias = Callable[[float, Decision | None], Array]
"""From plant time, s, and the filter's decision before to u_h, shape (m,)."""


def piecewise_constant(rng: np.random.Generator, m: int) -> Adversary:
    """Ask for something else about once a second."""
    until_s, u_h = 0.0, np.zeros(m)

    def ask(t_s: float, _: Decision | None) -> Array:
        nonlocal until_s, u_h
        if t_s >= until_s:
            until_s = t_s + rng.exponential(1.0)
            u_h = rng.uniform(-STRENGTH, STRENGTH, m)
        return u_h

    return ask


def chirp(rng: np.random.Generator, m: int) -> Adversary:
    """Swing ever faster, from 0.1 Hz to 50 Hz within 10 s."""
    amplitude, phase = rng.uniform(5.0, STRENGTH, m), rng.uniform(0, 2 * pi, m)
    rate = np.log(500.0) / 10.0

    def ask(t_s: float, _: Decision | None) -> Array:
        cycles = 0.1 * (np.exp(rate * t_s) - 1) / rate
        return np.asarray(amplitude * np.cos(2 * pi * cycles + phase))

    return ask


def bang_bang(rng: np.random.Generator, m: int) -> Adversary:
    """Throw the robot at the tightest row, let go, and again, with a period between 20 ms and 1 s."""
    period_s = float(np.exp(rng.uniform(np.log(0.02), 0.0)))

    def ask(t_s: float, decision: Decision | None) -> Array:
        sign = 1.0 if cos(2 * pi * t_s / period_s) > 0 else -1.0
        return sign * STRENGTH * _against(decision, m, _tightest_hard)

    return ask


def against_h(_rng: np.random.Generator, m: int) -> Adversary:
    """Push with full strength against the tightest hard row, always."""
    return lambda _t_s, decision: STRENGTH * _against(decision, m, _tightest_hard)


def against_the_tank(_rng: np.random.Generator, m: int) -> Adversary:
    """Push with full strength where energy is drawn fastest."""
    return lambda _t_s, decision: STRENGTH * _against(decision, m, _passivity)


ADVERSARIES: Final = {
    "piecewise-constant": piecewise_constant,
    "chirp": chirp,
    "bang-bang": bang_bang,
    "against-h": against_h,
    "against-the-tank": against_the_tank,
}


def _against(decision: Decision | None, m: int, row_of: Callable[[Decision, int], Array]) -> Array:
    """Direction of unit length in the maximum norm that leads into a row; the first axis where there is none."""
    direction = np.eye(1, m)[0] if decision is None else -row_of(decision, m)
    size = float(np.abs(direction).max(initial=0.0))
    return direction / size if size > 0 else np.eye(1, m)[0]


def _tightest_hard(decision: Decision, m: int) -> Array:
    G, slacks = _rows(decision, m)
    hard = decision.part("relax").size
    return G[int(np.argmin(slacks[:hard]))] if hard else np.zeros(m)


def _passivity(decision: Decision, m: int) -> Array:
    G, _ = _rows(decision, m)
    hard = decision.part("relax").size
    return G[-1] if len(G) > hard else np.zeros(m)


def _rows(decision: Decision, m: int) -> tuple[Array, Array]:
    """Gradients of the duties' rows, shape (duties, m), and how far the decision is from each."""
    d = decision.part("d")
    G = decision.part("G").reshape((d.size, decision.part("z").size), order="F")
    return G[:, :m], decision.margins[: d.size]
