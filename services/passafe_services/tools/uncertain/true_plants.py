"""True plants, each a member of its own of the sets, followed together through a period, and the least h on the way."""

from typing import Final

import casadi as ca
import numpy as np

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.design import FilterDesign
from passafe.numerics.workspace import Array, BlockLayout, dense_function

PARTS: Final = 4
"""Steps of Runge and Kutta's fourth-order method in a period; h is looked at after each."""


class TruePlants:
    """Plants under held inputs and disturbances, with parameters of their own."""

    def __init__(self, design: FilterDesign, parameters: Array) -> None:
        """Derive the step.

        Args:
            design: Gives plant, barriers and period.
            parameters: Of every plant, in the order of the system's, shape (parameters, count).
        """
        system, h_s = design.system, design.dt_s / PARTS
        theta = ca.vertcat(ca.SX(0, 1), *(each.symbol for each in system.parameters))
        w = ca.SX.sym("w", system.n)
        rate = ca.Function("rate", [system.x, system.u, theta, w], [system.general_f + w])
        h_of = ca.Function("h", [system.x], [ca.vertcat(ca.SX(0, 1), *(barrier.h for barrier in design.barriers))])
        x, along = system.x, []
        for _ in range(PARTS):
            k_1 = rate(x, system.u, theta, w)
            k_2 = rate(x + h_s / 2 * k_1, system.u, theta, w)
            k_3 = rate(x + h_s / 2 * k_2, system.u, theta, w)
            k_4 = rate(x + h_s * k_3, system.u, theta, w)
            x = x + h_s / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
            along.append(h_of(x))
        least = ca.mmin(ca.vertcat(*along))
        sizes = {"x": system.n, "u": system.m, "theta": theta.numel(), "w": system.n, "x_next": system.n, "h": 1}
        self._space = BatchWorkspace(BlockLayout.of(sizes), parameters.shape[1])
        self._space.part("theta")[:, : self._space.used] = parameters
        function = dense_function("follow", [system.x, system.u, theta, w], [x, least])
        self._follow = self._space.bind(function, ["x", "u", "theta", "w"], ["x_next", "h"])

    def advance(self, x: Array, u: Array, w: Array) -> tuple[Array, Array]:
        """Return states at the end of a period, shape (n, count), and the least h within it, shape (count,).

        Args:
            x: States at its beginning, shape (n, count).
            u: Inputs, shape (m, count).
            w: Disturbances, shape (n, count).
        """
        space, used = self._space, self._space.used
        for name, value in (("x", x), ("u", u), ("w", w)):
            space.part(name)[:, :used] = value
        self._follow()
        return space.part("x_next")[:, :used].copy(), space.part("h")[0, :used].copy()


class LowestLevel:
    """The barrier's function that is lowest at a state, where it leads, and how far away its boundary is."""

    def __init__(self, design: FilterDesign, levels: ca.SX, count: int) -> None:
        """Derive it.

        Args:
            design: Gives the states.
            levels: Functions of x, ψ_{r−1} of every barrier, shape (C, 1).
            count: How many states.
        """
        x = design.system.x
        h = ca.vertcat(*(barrier.h for barrier in design.barriers))
        gaps = h / ca.sqrt(ca.sum2(ca.jacobian(h, x) ** 2))
        self._shape = (levels.numel(), design.system.n)
        sizes = {"x": design.system.n, "levels": levels.numel(), "slopes": levels.numel() * design.system.n, "gap": 1}
        self._space = BatchWorkspace(BlockLayout.of(sizes), count)
        function = dense_function("levels", [x], [levels, ca.vec(ca.jacobian(levels, x).T), ca.mmin(gaps)])
        self._evaluate = self._space.bind(function, ["x"], ["levels", "slopes", "gap"])

    def slope(self, x: Array) -> Array:
        """Return the gradient of the lowest level of every state, shape (n, count)."""
        self._at(x)
        used, (count, n) = self._space.used, self._shape
        lowest = self._space.part("levels")[:, :used].argmin(axis=0)
        slopes = self._space.part("slopes")[:, :used].reshape(count, n, used)
        return np.asarray(slopes[lowest, :, np.arange(used)].T)

    def gap(self, x: Array) -> Array:
        """Return the distance to the nearest boundary, m, accurate to first order, shape (count,)."""
        self._at(x)
        return self._space.part("gap")[0, : self._space.used].copy()

    def _at(self, x: Array) -> None:
        self._space.part("x")[:, : self._space.used] = x
        self._evaluate()
