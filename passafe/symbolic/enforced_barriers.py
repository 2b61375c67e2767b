"""The barriers that a design enforces: their rows, margins between samples, and shortfall."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign, Law
from passafe.enclosures.reachable_tube import Tube
from passafe.margins.intersample_margin import DeviationBound, HeldRow, general_row, held_row
from passafe.margins.member_bound import MemberBound, member_bound
from passafe.margins.plant_family import PlantFamily
from passafe.symbolic.rows import TINY, ConstraintRow, row_at
from passafe.system import System

TANGENT_ERROR: Final = 1e-5
"""Largest violation of a row that is not affine in u where no margin between samples is asked for, units of u."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class HeldBarrier:
    """The conditions of one barrier on a held input: of the branch that holds best, where it is a maximum.

    Attributes:
        system: The plant.
        chain: The barrier's.
        rows: Conditions of each of its branches.
        general: A family of plants, and the same with the symbols of its coordinates in them; none without a family.
    """

    system: System
    chain: BarrierChain
    rows: tuple[HeldRow, ...]
    general: tuple[tuple[PlantFamily, HeldRow], ...] = ()

    @classmethod
    def of(cls, chain: BarrierChain, held_s: float, family: PlantFamily | None) -> "HeldBarrier":
        """Return the conditions of a chain under an input that is held for ``held_s`` seconds at most."""
        system = chain.system
        if family is None:
            return cls(system=system, chain=chain, rows=tuple(held_row(system, b, held_s) for b in chain.branches))
        general = tuple(general_row(family.system, branch, held_s) for branch in chain.branches)
        rows = tuple(
            held_row(system, branch, held_s, decay_per_s=row.decay_per_s)
            for branch, row in zip(chain.branches, general, strict=True)
        )
        return cls(system=system, chain=chain, rows=rows, general=tuple((family, row) for row in general))

    @property
    def value(self) -> ca.SX:
        """ψ_r under an input that is held, expression of x, u and t."""
        return self.chain.chosen([row.value for row in self.rows])

    @property
    def bend(self) -> ca.SX:
        """Part of the second condition that is known, expression of x, u and t."""
        return self.chain.chosen([row.bend for row in self.rows])

    def deviation(self, tube: Tube, held_s: float, trust: ca.SX) -> DeviationBound:
        """Return the bound of what is unknown, faded out linearly outside of the set, where nothing is to be kept.

        Args:
            tube: Around x, expressions of the system's u.
            held_s: T, s.
            trust: By how much each axis of the held input may differ from u, shape (m, 1).
        """
        sizes, knowns = [], []
        for row in self.rows:
            size, known = row.deviation(self.system, tube, held_s, trust)
            sizes.append(ca.if_else(known, size, 0) + ca.fmin(row.p, 0) / row.usable_s)
            knowns.append(known)
        return DeviationBound(self.chain.chosen(sizes), self.chain.chosen(knowns))

    def member_bound(self, tube: Tube, held_s: float, x_radius: ca.SX, trust: ca.SX) -> MemberBound:
        """Return the bounds for all members of a family, from states within ``x_radius`` of x.

        Args:
            tube: Of all of them, expressions of the system's u.
            held_s: T, s.
            x_radius: Error of x, shape (n, 1).
            trust: By how much each axis of the held input may differ from u, shape (m, 1).
        """
        found = [member_bound(family, row, tube, held_s, x_radius, trust) for family, row in self.general]
        return MemberBound(*(self.chain.chosen(each) for each in zip(*found, strict=True)))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class EnforcedBarriers:
    """Enforced barriers of one design.

    Attributes:
        design: The design.
        chains: Chains of the enforced barriers; none where the mode does not enforce safety.
        held: The conditions of each on an input that is held.
        has_margins: Whether rows have margins between samples.
        family: The plants for which rows are to hold; ``None`` for the model alone.
    """

    design: FilterDesign
    chains: tuple[BarrierChain, ...]
    held: tuple[HeldBarrier, ...]
    has_margins: bool
    family: PlantFamily | None = None

    @classmethod
    def of(
        cls, design: FilterDesign, chains: Sequence[BarrierChain], family: PlantFamily | None = None
    ) -> "EnforcedBarriers":
        """Return the barriers that the design's mode enforces, of all its chains."""
        enforced = tuple(chains) if design.mode.enforces_safety else ()
        return cls(
            design=design,
            chains=enforced,
            held=tuple(HeldBarrier.of(chain, design.held_s, family) for chain in enforced),
            has_margins=design.law is Law.SAMPLED and design.between_samples and bool(enforced),
            family=family,
        )

    @property
    def are_affine(self) -> bool:
        """True if every row without its margin is affine in u."""
        u = self.design.system.u
        return not any(ca.depends_on(ca.gradient(held.value, u), u) for held in self.held)

    def lowest_psi(self) -> ca.SX:
        """Return the smallest of all ψ₀ … ψ_{r−1}, scalar; 0 without barriers."""
        psi = [psi for chain in self.chains for psi in chain.psi[:-1]]
        return ca.mmin(ca.vertcat(*psi)) if psi else ca.SX(0)

    def deviations(self, tube: Tube, u_lin: ca.SX, trust: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the deviation of every barrier for all inputs within ``trust`` of u_lin, and how many are unknown.

        Args:
            tube: Around x for these inputs, expressions of the system's u.
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
        """
        sizes, unknown = [ca.SX(0, 1)], ca.SX(0)
        for held in self.held if self.has_margins else ():
            both = held.deviation(tube, self.design.held_s, trust)
            size, known = ca.substitute([*both], [self.design.system.u], [u_lin])
            sizes.append(size)
            unknown += 1 - known
        if not self.has_margins:
            sizes.append(ca.SX.zeros(len(self.held)))
        return ca.vertcat(*sizes), unknown

    def member_bounds(self, tube: Tube, x_radius: ca.SX, u_lin: ca.SX, trust: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return deviation and uncertainty of every barrier for a family of plants, and how many are unknown.

        Args:
            tube: Of all members, for all inputs within ``trust`` of u_lin, expressions of the system's u.
            x_radius: Error of x, shape (n, 1).
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
        """
        sizes, uncertain, unknown = [ca.SX(0, 1)], [ca.SX(0, 1)], ca.SX(0)
        for held in self.held:
            bound = held.member_bound(tube, self.design.held_s, x_radius, trust)
            size, less, known = ca.substitute([*bound], [self.design.system.u], [u_lin])
            sizes.append(size)
            uncertain.append(less)
            unknown += 1 - known
        return ca.vertcat(*sizes), ca.vertcat(*uncertain), unknown

    def rows(
        self,
        u_ref: ca.SX,
        u_lin: ca.SX,
        deviation: ca.SX,
        uncertainty: ca.SX,
        margins: ca.SX,
        tightening: ca.SX,
    ) -> list[ConstraintRow]:
        """Return the sampled law's rows, kept with the tightening to spare.

        Of the two conditions of a barrier the row is that which asks for more at u_lin.

        Args:
            u_ref: Where w is zero, shape (m, 1).
            u_lin: Where tangents touch, shape (m, 1).
            deviation: Of every barrier.
            uncertainty: Of every barrier, for a family of plants; else empty.
            margins: 1 to have margins, 0 to leave them out.
            tightening: Scalar, units of u.
        """
        system, rows = self.design.system, []
        for i, (chain, held) in enumerate(zip(self.chains, self.held, strict=True)):
            function = held.value if self.family is None else held.value - uncertainty[i]
            if self.has_margins:
                bends = ca.substitute(held.bend, system.u, u_lin) < deviation[i]
                function = function + ca.if_else(bends, margins, 0) * (held.bend - deviation[i])
            row = row_at(system, chain.barrier.name, function, u_ref, u_lin)
            value = row.value - tightening * ca.norm_2(row.gradient)
            rows.append(ConstraintRow(name=row.name, value=value, gradient=row.gradient))
        return rows

    def margins(self, u_plus: ca.SX, deviation: ca.SX) -> ca.SX:
        """Return every ε at u⁺: what ``HeldRow.value`` has to be at least, in the units of ψ_r; 0 where none is wanted.

        What members of a family take comes on top.

        Args:
            u_plus: Shape (m, 1).
            deviation: Of every barrier.
        """
        if not self.has_margins:
            return ca.SX.zeros(len(self.held))
        bends = ca.vertcat(ca.SX(0, 1), *(held.bend for held in self.held))
        return ca.fmax(deviation - ca.substitute(bends, self.design.system.u, u_plus), 0)

    def graded(self, u_plus: ca.SX, eps: ca.SX, deviation: ca.SX, uncertainty: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return shortfall and waste of an answer, scalars, units of u.

        The shortfall is the distance by which u⁺ violates a row with its margin, ≤ 0 if it keeps all. The waste is how
        far from u⁺ a margin may keep better answers by what is unknown alone, in all of the trust region.

        Args:
            u_plus: Shape (m, 1).
            eps: Margins of all barriers.
            deviation: What is unknown of them.
            uncertainty: What members of a family take of them; else empty.
        """
        u, sampled = self.design.system.u, self.design.law is Law.SAMPLED
        missing, lost = [ca.SX(0)], [ca.SX(0)]
        for i, held in enumerate(self.held if sampled else ()):
            value, gradient = ca.substitute([held.value, ca.gradient(held.value, u)], [u], [u_plus])
            length = ca.fmax(ca.norm_2(gradient), TINY)
            value = value if self.family is None else value - uncertainty[i]
            if self.has_margins:
                per_unit = 1 / length
                missing.append((eps[i] - value) * per_unit)
                if held.chain.barrier.derivative_bounds is None:  # given ones hardly change with the trust region
                    lost.append(ca.fmin(eps[i], deviation[i]) * per_unit)
            elif ca.depends_on(ca.gradient(held.value, u), u):
                missing.append((eps[i] - value) / length - TANGENT_ERROR)
        return ca.mmax(ca.vertcat(*missing)), ca.mmax(ca.vertcat(*lost))
