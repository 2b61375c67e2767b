"""The plant under a held input at many instants of a period, by an integration of its own.

Linear plants: the matrix exponential, exact. Others: from one instant to the next the classical Runge–Kutta step, twice
and once more with half the step, extrapolated; where their difference is too large, the period is integrated again by
SciPy's DOP853. Neither shares code with ``passafe.sampled_plant``, by which the filter's own claims are tested.
"""

from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np
from scipy.integrate import DOP853
from scipy.linalg import expm

from passafe.numerics.workspace import Array, BlockLayout, Workspace, dense_function
from passafe.sampled_plant import is_linear
from passafe.system import System

POINTS: Final = 10
"""Instants of every period, its end included."""

ACCURACY: Final = 1e-9
"""Largest estimated error of a step, relative to 1 + |x|."""

MOST_STEPS: Final = 600
"""Steps of controlled length in one period, at most: near a singular point they would become ever shorter."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DensePeriod:
    """One period.

    Attributes:
        states: x at its beginning and at ``POINTS`` instants, shape (n, POINTS + 1).
        output: ∫y from its beginning, shape (m, POINTS + 1).
    """

    states: Array
    output: Array


class DenseFlow:
    """Follows x and ∫y over one period."""

    def __init__(self, system: System, dt_s: float) -> None:
        """Derive the steps.

        Args:
            system: The plant.
            dt_s: Period, s.
        """
        self._n, self._m, self._step_s = system.n, system.m, dt_s / POINTS
        self._rate = ca.Function("rate", [system.x, system.u], [ca.vertcat(system.f, system.y)])
        self._powers = _powers(system, self._step_s) if is_linear(system) else None
        if self._powers is None:
            size = self._n + self._m
            sizes = {"s": size, "u": self._m * POINTS, "flow": size * POINTS, "error": POINTS}
            self._space = space = Workspace(BlockLayout.of(sizes))
            step = _extrapolated_step(self._rate, self._n, self._m, self._step_s)
            self._advance = space.bind(step.mapaccum("flow", POINTS), ["s", "u"], ["flow", "error"])

    def over(self, x: Array, u: Array) -> DensePeriod:
        """Return the period that begins in x with u held, shapes (n,) and (m,)."""
        n, m = self._n, self._m
        start = np.concatenate([x, np.zeros(m)])
        if self._powers is not None:
            after = (self._powers @ np.concatenate([start, u, [1.0]])).reshape(POINTS, n + m).T
        else:
            after = self._extrapolated(start, u)
        whole = np.concatenate([start[:, None], after], axis=1)
        return DensePeriod(states=whole[:n], output=whole[n:])

    def _extrapolated(self, start: Array, u: Array) -> Array:
        part = self._space.part
        part("s")[:] = start
        part("u")[:] = np.tile(u, POINTS)
        self._advance()
        after = part("flow").reshape(POINTS, -1).T.copy()
        if part("error").max() <= ACCURACY:
            return after
        return self._with_care(start, u)

    def _with_care(self, start: Array, u: Array) -> Array:
        """Return the period by steps of controlled length; NaN from where ``MOST_STEPS`` do not lead on."""
        instants = self._step_s * np.arange(1, POINTS + 1)
        reached = np.full((len(start), POINTS), np.nan)
        solver = DOP853(
            lambda _, s: self._rate(s[: self._n], u).full().ravel(), 0.0, start, instants[-1], rtol=1e-9, atol=1e-11
        )
        for _ in range(MOST_STEPS):
            if solver.status != "running":
                break
            solver.step()
            if solver.status == "failed":
                break
            passed = (instants > solver.t_old) & (instants <= solver.t)
            if passed.any():
                reached[:, passed] = solver.dense_output()(instants[passed])
        return reached


def _powers(system: System, step_s: float) -> Array:
    """Return the matrix from [x, q, u, 1] to all [x, q] of a period, one instant below the other."""
    n, m = system.n, system.m
    z = ca.vertcat(system.x, system.u)
    rate = ca.Function("rate", [z], [ca.vertcat(system.f, system.y)])
    constant = rate(ca.DM.zeros(n + m)).full()
    slope = np.hstack([rate(ca.DM(e)).full() - constant for e in np.eye(n + m)])
    M = np.zeros((n + 2 * m + 1,) * 2)
    M[: n + m, :n], M[: n + m, n + m : -1], M[: n + m, -1:] = slope[:, :n], slope[:, n:], constant
    return np.vstack([expm(M * step_s * k)[: n + m] for k in range(1, POINTS + 1)])


def _extrapolated_step(rate: ca.Function, n: int, m: int, step_s: float) -> ca.Function:
    """Return (s, u) → (s after a step, its estimated error relative to 1 + |s|) for s = [x, ∫y]."""
    s, u = ca.SX.sym("s", n + m), ca.SX.sym("u", m)

    def step(s: ca.SX, h: float) -> ca.SX:
        k1 = rate(s[:n], u)
        k2 = rate((s + h / 2 * k1)[:n], u)
        k3 = rate((s + h / 2 * k2)[:n], u)
        k4 = rate((s + h * k3)[:n], u)
        return s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    halves = step(step(s, step_s / 2), step_s / 2)
    quarters = s
    for _ in range(4):
        quarters = step(quarters, step_s / 4)
    correction = (quarters - halves) / 15
    error = ca.norm_inf(correction / (1 + ca.fabs(quarters)))
    return dense_function("step", [s, u], [quarters + correction, error])
