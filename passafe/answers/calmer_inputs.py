"""Inputs that move the state less, for rows whose margins grow steeply with the input.

Between samples the state moves with the input, and the margin with that: where the wanted input's own margin leaves no
room, a calmer one's may.
"""

from collections.abc import Iterator
from typing import Final

import casadi as ca
import numpy as np

from passafe.design import FilterDesign
from passafe.numerics.fixed_order import least_squares
from passafe.numerics.workspace import Array
from passafe.symbolic.trust_region import LEAST_TRUST

SHARES: Final = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.0)
"""Shares of the way from the input that moves the state least to the wanted one."""


class CalmerInputs:
    """Finds the input that moves a plant's state least, and those on the way to it."""

    def __init__(self, design: FilterDesign) -> None:
        """Derive the plant's motion: f(x, 0) and its slope in u there."""
        system, self._limits = design.system, design.limits
        none = ca.SX.zeros(system.m)
        drift, effect = ca.substitute([system.f, ca.jacobian(system.f, system.u)], [system.u], [none])
        self._motion = ca.Function("motion", [system.x], [ca.densify(drift), ca.densify(effect)])
        self._least_trust: Array = LEAST_TRUST * np.array(design.limits.magnitude)

    def towards(self, wanted: Array, x: Array, u: Array, low: Array, high: Array) -> Iterator[tuple[Array, Array]]:
        """Return inputs ever nearer to the calmest one, all within the limits, and a trust region for each.

        Args:
            wanted: Where they begin, within the limits, shape (m,).
            x: State, shape (n,).
            u: Input before, shape (m,).
            low: Least input that magnitude and rate allow, shape (m,).
            high: Largest one, shape (m,).
        """
        drift, effect = (each.full() for each in self._motion(x))
        least = least_squares(effect, -drift.ravel())
        calmest = self._limits.nearest(least, u, low, high)
        way = wanted - calmest
        for share in SHARES:
            yield calmest + share * way, share / 2 * np.abs(way) + self._least_trust
