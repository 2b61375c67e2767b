"""A filter's rows at many states at once, all of them hard and in u itself."""

from dataclasses import dataclass, replace
from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.barrier_chain import derive_chains
from passafe.batch.batch_function import BatchFunction
from passafe.decision_schema import Program
from passafe.design import FilterDesign, Law, Mode
from passafe.limits import Limits
from passafe.numerics.workspace import Array
from passafe.symbolic.derivation import Derivation, first_tightening
from passafe.symbolic.rows import TINY
from passafe.symbolic.trust_region import LEAST_TRUST
from passafe_services.tools.feasibility.errors import FeasibilityError

Kept = NDArray[np.bool_]

FURTHEST: Final = 2.0
"""Bounds are drawn in to this many times the longest way between two inputs, as the filter does (``stack``)."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StateRows:
    """G u ≥ d at each of C states, rows of unit length, so that G u − d is a distance in units of u.

    As in the filter, a bound further away than any input can go is drawn in: margins beyond are not distinguished.

    Attributes:
        G: Shape (C, N, m).
        d: Shape (C, N).
    """

    G: Array
    d: Array

    def margin(self, u: Array) -> Array:
        """Return by how much all rows are kept by one input for each state, negative if not, shape (C,).

        Without a row it is infinite; where a row is no number, minus infinity.

        Args:
            u: Shape (C, m).
        """
        room = np.einsum("cnm,cm->cn", self.G, u) - self.d
        smallest: Array = np.where(np.isnan(room), -np.inf, room).min(axis=1, initial=np.inf)
        return smallest


class BatchRows:
    """The rows that the filter of a design puts into its quadratic program, evaluated by the filter's own functions.

    Safety and passivity are both asked for, whatever the design's mode. The sampled law's rows do not depend on the
    input before; only limits of the rate would, and they are left out.

    Attributes:
        limits: What the actuators can do.
        least_trust: Smallest change of u for which a margin between samples is good, shape (m,).
        tolerance: By how much a row may be missed, as for the filter's answers, units of u.
    """

    def __init__(self, design: FilterDesign, t_s: float) -> None:
        """Derive the rows.

        Args:
            design: The filter's.
            t_s: Plant time, s; without effect where no barrier moves.

        Raises:
            FeasibilityError: The continuous law, whose rows depend on the input before.
            DesignError: Some part of the design cannot be used.
        """
        if design.law is not Law.SAMPLED:
            raise FeasibilityError("filter.law", design.law.value, "sampled: the other's rows need the input before")
        both = replace(design, mode=Mode.BOTH)
        chains = tuple(chain for one in design.barriers for chain in derive_chains(design.system, one))
        self._derivation = Derivation.of(both, chains)
        self.limits: Limits = design.limits
        self.least_trust: Array = LEAST_TRUST * np.array(design.limits.magnitude)
        self.tolerance = design.tolerance.residual
        self._prepare = BatchFunction(self._derivation.functions.prepare, by_casadi=True)
        self._m, self._hard = design.system.m, self._derivation.rows.hard
        tank = design.passivity.tank
        self._constant = {
            "t": t_s,
            "tank": 0.0 if tank is None else tank.initial_j,
            "start": 1.0,
            "tightening": first_tightening(design),
            "with_margins": 1.0,
        }
        h = [chain.psi[0] for chain in chains]
        protecting = [psi for chain in chains for psi in chain.psi[:-1]]
        at_t = ca.substitute([ca.vertcat(np.inf, *h), ca.vertcat(np.inf, *protecting)], [design.system.t], [ca.SX(t_s)])
        self._inside = ca.Function("inside", [design.system.x], [ca.densify(values) for values in at_t])

    def barriers(self, x: Array) -> tuple[Array, Array]:
        """Return the smallest h, and the smallest of all ψ₀ … ψ_{r−1}, at each state, shapes (C,).

        Args:
            x: States, shape (n, C).
        """
        h, protecting = (value.full().min(axis=0) for value in self._inside(x))  # ca.mmin would swallow a NaN
        return h, protecting

    def rows(self, x: Array, u_lin: Array, trust: Array, *, passive: bool) -> StateRows:
        """Return the rows with margins that are good for every input within ``trust`` of ``u_lin``.

        Args:
            x: States, shape (n, C).
            u_lin: One input for each state, where tangents touch, shape (C, m).
            trust: Change of each axis, shape (C, m).
            passive: Whether the passivity row, without slack, is among them.
        """
        count, m = x.shape[1], self._m
        given = self._constant | {"x": x, "u_lin": u_lin.T, "trust_asked": trust.T}
        shapes = self._derivation.layout.shapes
        columns = [
            np.broadcast_to(np.asarray(given.get(name, 0.0), dtype=np.float64), (*shapes[name], count))
            for name in self._prepare.function.name_in()
        ]
        found = dict(zip(self._prepare.function.name_out(), self._prepare(*columns), strict=True))
        program = Program.of(found.__getitem__)
        constraints, k = shapes["G"]
        G = program.G.reshape(k, constraints, count).transpose(2, 1, 0)[:, :, :m]
        # fmin and fmax swallow a NaN; the filter sees it by its guard, too.
        sound = program.nan_guard.T <= 1.0
        d, u_ref = np.where(sound, program.d.T, np.nan), program.u_ref.T
        chosen = constraints if passive else self._hard
        return _hardened(G[:, :chosen], d[:, :chosen], u_ref, FURTHEST * self.limits.reach)


def _hardened(G: Array, d: Array, u_ref: Array, furthest: float) -> StateRows:
    """Return rows in u from rows in u − u_ref, unit length restored where a slack's column had its share of it."""
    length = np.maximum(np.linalg.norm(G, axis=2), TINY)
    unit = G / length[:, :, None]
    bound = np.clip(d / length, -furthest, furthest)
    return StateRows(G=unit, d=bound + np.einsum("cnm,cm->cn", unit, u_ref))
