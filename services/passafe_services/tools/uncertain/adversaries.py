"""Adversary operators and disturbances of uncertain campaigns, one of each for a rollout, drawn from its seed."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from passafe.numerics.workspace import Array
from passafe_services.tools.uncertain.true_plants import LowestLevel

KINDS: Final = ("constant", "switching", "greedy")
"""Operators and disturbances are of these kinds, in turn."""

STRENGTH: Final = 10.0
"""Length of u_h, units of u."""

OPERATOR_SWITCHES_S: Final = 0.3
DISTURBANCE_SWITCHES_S: Final = 0.1
"""Mean time after which a switching one changes, s."""


class Adversaries:
    """Operators and disturbances of the plants of a batch; what a rollout meets depends on its seed alone.

    Attributes:
        operators: Kind of each operator.
        disturbances: Kind of each disturbance.
    """

    def __init__(self, seeds: Sequence[int], rngs: Sequence[np.random.Generator], x: Array, bounds: Array) -> None:
        """Draw directions.

        Args:
            seeds: Of the rollouts.
            rngs: A generator for each.
            x: True states at the start, shape (n, count).
            bounds: Largest disturbance of each state's rate, shape (n,).
        """
        self._rngs, self._bounds = rngs, bounds[:, None]
        self.operators = [KINDS[seed % 3] for seed in seeds]
        self.disturbances = [KINDS[seed // 3 % 3] for seed in seeds]
        towards = -x[:2] / np.maximum(np.linalg.norm(x[:2], axis=0), 1e-9)
        self._u_h = STRENGTH * towards
        self._w = self._bounds * np.array([rng.choice([-1.0, 1.0], len(bounds)) for rng in rngs]).T
        self._next_operator, self._next_disturbance = np.zeros(len(seeds)), np.zeros(len(seeds))
        self._greedy_operator = np.array([kind == "greedy" for kind in self.operators])
        self._greedy_disturbance = np.array([kind == "greedy" for kind in self.disturbances])

    def ask(self, t_s: float, into_rows: Array) -> Array:
        """Return what the operators ask for, shape (m, count).

        Args:
            t_s: Plant time, s.
            into_rows: Direction against the tightest row of each filter's last decision, shape (m, count).
        """
        for i in np.flatnonzero(self._next_operator <= t_s).tolist():
            if self.operators[i] == "switching":
                direction = self._rngs[i].normal(size=2)
                self._u_h[:, i] = STRENGTH * direction / np.linalg.norm(direction)
                self._next_operator[i] = t_s + self._rngs[i].exponential(OPERATOR_SWITCHES_S)
            else:
                self._next_operator[i] = np.inf
        return np.where(self._greedy_operator, STRENGTH * into_rows, self._u_h)

    def push(self, t_s: float, x: Array, lowest: LowestLevel) -> Array:
        """Return the disturbances, shape (n, count).

        Args:
            t_s: Plant time, s.
            x: True states, shape (n, count).
            lowest: Where a greedy one pushes: down the lowest level.
        """
        if not self._bounds.any():
            return np.zeros_like(x)
        for i in np.flatnonzero(self._next_disturbance <= t_s).tolist():
            if self.disturbances[i] == "switching":
                self._w[:, i] = self._bounds[:, 0] * self._rngs[i].choice([-1.0, 1.0], len(self._bounds))
                self._next_disturbance[i] = t_s + self._rngs[i].exponential(DISTURBANCE_SWITCHES_S)
            else:
                self._next_disturbance[i] = np.inf
        down = -self._bounds * np.sign(lowest.slope(x))
        return np.where(self._greedy_disturbance, down, self._w)
