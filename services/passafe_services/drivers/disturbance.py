"""Disturbances of a simulated robot: what is added to its rates in each period, a function of period and state."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import pi, sin
from typing import Final, TypeAlias

import casadi as ca
import numpy as np
from passafe_protocol.messages import Vector

from passafe.barrier_chain import Barrier, derive_chains
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function
from passafe.system import System

Disturbing: TypeAlias = Callable[[float, Vector], Vector]
"""Returns what is added to the rates, n numbers, for a time since the start, s, and the true state then."""

_SLACK: Final = 1e-9
"""Rounding of a time that is a whole number of periods, in the unit of the draws."""


def switching(bound: Vector, every_s: float, seed: int) -> Disturbing:
    """Return a disturbance of full size whose signs are drawn anew every so many seconds."""

    @lru_cache(maxsize=4)
    def drawn(number: int) -> Vector:
        signs = np.random.default_rng((seed, number)).choice((-1.0, 1.0), len(bound))
        return tuple((signs * bound).tolist())

    return lambda t_s, _: drawn(int(t_s / every_s + _SLACK))


def sine(bound: Vector, period_s: float) -> Disturbing:
    """Return a disturbance that swings, each state's a quarter of a period behind the one before."""
    phases = [i * pi / 2 for i in range(len(bound))]
    return lambda t_s, _: tuple(
        most * sin(2 * pi * t_s / period_s - phase) for most, phase in zip(bound, phases, strict=True)
    )


class Greedy:
    """Disturbance that lowers the lowest ψ_{r−1} of all barriers as fast as its bounds allow."""

    def __init__(self, bound: Vector, system: System, barriers: Sequence[Barrier]) -> None:
        """Derive the push.

        Args:
            bound: Magnitude for each state's rate, n numbers.
            system: Model of the robot.
            barriers: Barriers to push against.
        """
        chains = [chain for barrier in barriers for chain in derive_chains(system, barrier)]
        lowest, slope = ca.SX(float("inf")), ca.SX.zeros(system.n)
        for low in (branch.psi[-2] for chain in chains for branch in chain.branches):
            slope = ca.if_else(low < lowest, ca.densify(ca.gradient(low, system.x)), slope)
            lowest = ca.fmin(lowest, low)
        push = -ca.DM(list(bound)) * ca.sign(slope)
        self._space = space = Workspace(BlockLayout.of({"x": system.n, "t": 1, "w": system.n}))
        self._evaluate = space.bind(dense_function("greedy", [system.x, system.t], [push]), ("x", "t"), ("w",))
        self._write, self._read = space.span_writer(("x", "t")), space.reader("w")

    def __call__(self, t_s: float, x: Vector) -> Vector:
        """Return the push at a time and true state, n numbers."""
        self._write(*x, t_s)
        self._evaluate()
        return self._read()
