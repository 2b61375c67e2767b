"""Least h, least ψ and least tank along a period, between samples too."""

from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array, BlockLayout, Workspace
from passafe_services.tools.generated.dense_flow import POINTS, DensePeriod
from passafe_services.tools.generated.generated_design import GeneratedDesign

_SHARES: Final = np.arange(POINTS + 1) / POINTS


class Lowest(NamedTuple):
    """Least values of one period.

    Attributes:
        h: Of all barriers.
        psi: Of all ψ₀ … ψ_{r−1}.
        tank_j: Energy in the tank, J.
        level_j: Tank at the end of the period, J.
    """

    h: float
    psi: float
    tank_j: float
    level_j: float


class Watch:
    """Evaluates what matters along a period."""

    def __init__(self, design: GeneratedDesign) -> None:
        """Compile the functions of one design."""
        system, chains = design.plant.system, design.chains
        self._dt_s, self._most_j = design.timing.dt_s, design.tank.max_j if design.tank else np.inf
        h = ca.mmin(ca.vertcat(*(chain.psi[0] for chain in chains)))
        psi = ca.mmin(ca.vertcat(*(psi for chain in chains for psi in chain.psi[:-1])))
        values = ca.densify(ca.vertcat(h, psi, design.plant.storage))
        function = ca.Function("watch", [system.x, system.t], [values]).map(POINTS + 1)
        instants = POINTS + 1
        self._space = Workspace(BlockLayout.of({"x": system.n * instants, "t": instants, "values": 3 * instants}))
        self._evaluate = self._space.bind(function, ["x", "t"], ["values"])

    def during(self, period: DensePeriod, u: Array, t_s: float, level_j: float) -> Lowest:
        """Return the least values of a period; −∞ where the plant left the numbers, which no minimum shows.

        Args:
            period: Its states.
            u: Input held over it, shape (m,).
            t_s: Time at its beginning, s.
            level_j: Tank at its beginning, J.
        """
        if not np.isfinite(period.states).all():
            return Lowest(-np.inf, -np.inf, -np.inf, -np.inf)
        part = self._space.part
        part("x")[:] = period.states.ravel(order="F")
        part("t")[:] = t_s + self._dt_s * _SHARES
        self._evaluate()
        h, psi, stored = part("values").reshape(-1, 3).T
        level = np.minimum(level_j + u @ period.output - (stored - stored[0]), self._most_j)
        return Lowest(float(h.min()), float(psi.min()), float(level.min()), float(level[-1]))
