"""The barriers that a design enforces: their rows, margins between samples, and shortfall."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign, Law
from passafe.intersample_margin import curvature_bound, held_function
from passafe.rows import TINY, ConstraintRow, row_at

TANGENT_ERROR: Final = 1e-5
"""Largest violation of a row that is not affine in u where no margin between samples is asked for, units of u."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class EnforcedBarriers:
    """Enforced barriers of one design.

    Attributes:
        design: The design.
        chains: Chains of the enforced barriers; none where the mode does not enforce safety.
        held: ψ_r of each under an input that is held, expression of x, u and t.
        has_margins: Whether rows have margins between samples.
    """

    design: FilterDesign
    chains: tuple[BarrierChain, ...]
    held: tuple[ca.SX, ...]
    has_margins: bool

    @classmethod
    def of(cls, design: FilterDesign, chains: Sequence[BarrierChain]) -> "EnforcedBarriers":
        """Return the barriers that the design's mode enforces, of all its chains."""
        enforced = tuple(chains) if design.mode.enforces_safety else ()
        return cls(
            design=design,
            chains=enforced,
            held=tuple(held_function(design.system, chain, design.held_s) for chain in enforced),
            has_margins=design.law is Law.SAMPLED and design.between_samples and bool(enforced),
        )

    def margins(self, u_lin: ca.SX, trust: ca.SX) -> ca.SX:
        """Return every ε for all inputs within ``trust`` of u_lin, in the units of ψ_r; 0 where none is wanted.

        Args:
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
        """
        return ca.vertcat(ca.SX(0, 1), *(self._margin(chain, u_lin, trust) for chain in self.chains))

    def rows(self, u_ref: ca.SX, u_lin: ca.SX, eps: ca.SX, tightening: ca.SX) -> list[ConstraintRow]:
        """Return the sampled law's rows, kept with ε and the tightening to spare.

        Args:
            u_ref: Where w is zero, shape (m, 1).
            u_lin: Where tangents touch, shape (m, 1).
            eps: Margins of all barriers.
            tightening: Scalar, units of u.
        """
        rows = []
        for i, (chain, held) in enumerate(zip(self.chains, self.held, strict=True)):
            row = row_at(self.design.system, chain.barrier.name, held, u_ref, u_lin)
            value = row.value - eps[i] - tightening * ca.norm_2(row.gradient)
            rows.append(ConstraintRow(name=row.name, value=value, gradient=row.gradient))
        return rows

    def shortfall(self, u_plus: ca.SX, eps: ca.SX) -> ca.SX:
        """Return the distance by which u⁺ violates a row with its margin, scalar, units of u; ≤ 0 if it keeps all.

        Args:
            u_plus: Shape (m, 1).
            eps: Margins of all barriers.
        """
        u = self.design.system.u
        missing = [ca.SX(0)]
        for i, held in enumerate(self.held if self.design.law is Law.SAMPLED else ()):
            value, gradient = ca.substitute([held, ca.gradient(held, u)], [u], [u_plus])
            short = (eps[i] - value) / ca.fmax(ca.norm_2(gradient), TINY)
            if self.design.between_samples:
                missing.append(short)
            elif ca.depends_on(ca.gradient(held, u), u):
                missing.append(short - TANGENT_ERROR)
        return ca.mmax(ca.vertcat(*missing))

    def _margin(self, chain: BarrierChain, u_lin: ca.SX, trust: ca.SX) -> ca.SX:
        if not self.has_margins:
            return ca.SX(0)
        system, held_s, r = self.design.system, self.design.held_s, chain.relative_degree
        p = chain.psi[r - 1]
        bound = curvature_bound(system, p, held_s, trust, steps=max(r, 2))
        margin = held_s / 2 * ca.fmax(ca.substitute(bound, system.u, u_lin), 0)
        # Outside the set there is nothing to keep between samples; there the margin fades out linearly.
        return ca.fmax(ca.fmin(margin, margin + p / held_s), 0)
