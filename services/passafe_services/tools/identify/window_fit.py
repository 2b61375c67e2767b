"""Fit of the model to windows of motion: parameters are common, state and disturbance at hand are each window's own.

In each window the model starts from a state of its own and is pushed by a constant disturbance of its own, on those
rates that inputs or parameters act on. Both are eliminated by a QR decomposition of their sensitivities (variable
projection), so that neither noise of single states nor slow pushes bias the parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.identify.motion_log import FloatArray, UnbrokenMotion

REWEIGHTINGS = 3
"""Fits in a row, each weighted by the noise that the one before found."""

ODD = 2.0
"""Mean square beyond which a window's residuals are odd, relative to the median: its disturbance was not constant."""

LEAST_NOISE = 1e-7
"""Noise below which a state counts as read exactly, relative to its range."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WindowFit:
    """Result of a fit.

    Attributes:
        names: Names of the parameters.
        values: Their estimates, shape (p,).
        errors: Their standard errors, shape (p,).
        residuals: States as read minus those of the model, in windows that are not odd, shape (N, n).
        noise: Standard deviation of each state's noise, shape (n,).
        pushes: Constant disturbance of each window on each rate, shape (windows, n).
    """

    names: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    residuals: FloatArray
    noise: FloatArray
    pushes: FloatArray


class WindowModel:
    """Model in a window, with its sensitivities.

    Attributes:
        pushed: States on whose rate inputs or parameters act.
    """

    def __init__(self, system: System, names: Sequence[str], dt_s: float, periods: int) -> None:
        """Derive and compile.

        Args:
            system: The model.
            names: Parameters to estimate.
            dt_s: Period, s.
            periods: Periods of a window.
        """
        by_name = {parameter.name: parameter for parameter in system.parameters}
        theta = ca.vertcat(ca.SX(0, 1), *(by_name[name].symbol for name in names))
        others = [each for each in system.parameters if each.name not in names]
        f = system.general_f
        if others:
            f = ca.substitute([f], [each.symbol for each in others], [ca.SX(each.value) for each in others])[0]
        acting = ca.vertcat(system.u, *(each.symbol for each in system.parameters))
        self.pushed = [i for i in range(system.n) if ca.depends_on(system.general_f[i], acting)]
        push = ca.SX.sym("push", len(self.pushed))
        w = ca.SX.zeros(system.n)
        for place, i in enumerate(self.pushed):
            w[i] = push[place]
        own = ca.vertcat(theta, push)
        rate = ca.Function("rate", [system.x, system.u, own], [f + w])
        x, u = system.x, system.u
        k1 = rate(x, u, own)
        k2 = rate(x + dt_s / 2 * k1, u, own)
        k3 = rate(x + dt_s / 2 * k2, u, own)
        k4 = rate(x + dt_s * k3, u, own)
        after = x + dt_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        n, p, q = system.n, len(names), len(self.pushed)
        S = ca.SX.sym("S", n, p + q + n)
        grown = ca.jacobian(after, x) @ S + ca.horzcat(ca.jacobian(after, own), ca.SX.zeros(n, n))
        state = ca.vertcat(x, ca.vec(S))
        step = ca.Function("step", [state, u, own], [ca.densify(ca.vertcat(after, ca.vec(grown)))], {"cse": True})
        self._roll = step.mapaccum("roll", periods)
        self._sizes = n, p, q, periods

    def run(self, x: FloatArray, u: FloatArray, theta: FloatArray, push: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return states of a window, shape (periods + 1, n), and sensitivities, (periods + 1, n, p + q + n)."""
        n, p, q, periods = self._sizes
        S = np.concatenate((np.zeros((n, p + q)), np.eye(n)), axis=1)
        begin = np.concatenate((x, S.ravel(order="F")))
        own = np.concatenate((theta, push))
        found = self._roll(begin, u[:periods].T, np.tile(own[:, None], periods)).full()
        columns = np.concatenate((begin[:, None], found), axis=1)
        return columns[:n].T, columns[n:].T.reshape(periods + 1, p + q + n, n).transpose(0, 2, 1)


class _Window:
    """One window with its own state and push, which it keeps from fit to fit."""

    def __init__(self, model: WindowModel, x: FloatArray, u: FloatArray) -> None:
        self._model, self._x, self._u = model, x, u
        self._start, self._push = x[0].copy(), np.zeros(len(model.pushed))

    def project(self, theta: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return weighted residuals and their slopes in theta, what is the window's own eliminated."""
        from scipy.linalg import qr, solve_triangular  # noqa: PLC0415 - see fit_windows

        p = theta.size
        for _ in range(2):  # its own part is linear or nearly so
            x, S = self._model.run(self._start, self._u, theta, self._push)
            r = ((self._x - x) / noise).ravel()
            slopes = (S / noise[None, :, None]).reshape(r.size, -1)
            Q, R = qr(slopes[:, p:], mode="economic", check_finite=False)
            change = solve_triangular(R + 1e-300 * np.eye(len(R)), Q.T @ r)
            q = self._push.size
            self._push = self._push + change[:q]
            self._start = self._start + change[q:]
        r = r - Q @ (Q.T @ r)
        J = slopes[:, :p]
        return r, -(J - Q @ (Q.T @ J))

    @property
    def push(self) -> FloatArray:
        """Push on the rates that can be pushed."""
        return self._push

    @property
    def own(self) -> int:
        """Number of unknowns of its own."""
        return int(self._push.size + self._start.size)


def fit_windows(
    system: System, stretches: Sequence[UnbrokenMotion], names: Sequence[str], dt_s: float, periods: int
) -> WindowFit:
    """Return the fit of a model to stretches of motion.

    Args:
        system: The model; parameters that are not named keep their values.
        stretches: LoggedMotion.
        names: Parameters to estimate.
        dt_s: Period, s.
        periods: Periods of a window.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - a fifth of a second that other commands need not wait

    model = WindowModel(system, names, dt_s, periods)
    windows = [
        _Window(model, stretch.x[begin : begin + periods + 1], stretch.u[begin : begin + periods])
        for stretch in stretches
        for begin in range(0, len(stretch.x) - periods, periods)
    ]
    value_of = {parameter.name: parameter.value for parameter in system.parameters}
    theta = np.array([value_of[name] for name in names])
    states = np.concatenate([stretch.x for stretch in stretches])
    least = LEAST_NOISE * (1e-3 + np.ptp(states, axis=0))
    noise = np.maximum(np.std(np.diff(states, axis=0), axis=0), least)
    residuals, J = np.zeros((0, states.shape[1])), np.zeros((0, theta.size))
    used = windows
    for _ in range(REWEIGHTINGS):
        if theta.size:
            theta = least_squares(
                lambda at, noise=noise, used=used: np.concatenate([w.project(at, noise)[0] for w in used]),
                theta,
                jac=lambda at, noise=noise, used=used: np.concatenate([w.project(at, noise)[1] for w in used]),
                x_scale=np.maximum(np.abs(theta), 1e-3),
                max_nfev=12,
            ).x
        parts = [window.project(theta, noise) for window in windows]
        of_windows = np.stack([r for r, _ in parts]).reshape(len(windows), periods + 1, -1) * noise
        squares = np.mean(of_windows**2, axis=1)
        typical = np.maximum(np.median(squares, axis=0), least**2)
        good = np.flatnonzero((squares <= ODD * typical).all(axis=1))
        used = [windows[k] for k in good] if good.size > len(windows) / 4 else windows
        kept = good if len(used) < len(windows) else np.arange(len(windows))
        residuals = of_windows[kept].reshape(-1, states.shape[1])
        J = np.concatenate([parts[k][1] for k in kept])
        free = 1 - windows[0].own / of_windows[0].size
        noise = np.sqrt(typical / max(free, 0.1))
    pushes = np.zeros((len(windows), system.n))
    pushes[:, model.pushed] = [window.push for window in windows]
    covariance = np.linalg.pinv(J.T @ J) if theta.size else np.zeros((0, 0))
    return WindowFit(
        names=tuple(names),
        values=theta,
        errors=np.sqrt(np.diag(covariance)),
        residuals=residuals,
        noise=noise,
        pushes=pushes,
    )
