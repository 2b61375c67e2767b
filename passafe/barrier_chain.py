"""Control barrier functions h(x, t) and the chain ψ₀ … ψ_r that carries them to the input.

Paper, section 3.1 and remark 2; high-order control barrier functions as in Xiao & Belta (2019).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TypeAlias

import casadi as ca

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described
from passafe.class_k import ClassK, class_k_functions
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.enclosures.jumps import require_no_jumps
from passafe.errors import DesignError, RelativeDegreeError
from passafe.expressions.chain_refusals import other_number, require_effect, require_one_degree, require_slope
from passafe.expressions.input_reach import InputReach, reach_of
from passafe.expressions.norms import without_singular_points
from passafe.expressions.smooth_parts import smooth_parts
from passafe.system import System

Reserve: TypeAlias = Callable[[ca.SX], ca.SX]
"""From an expression of x and t to a bound of how much less its rate may be than the model says, the same where no
input reaches it."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Barrier:
    """A safe set {x : h(x, t) ≥ 0} and the class-K functions of its chain.

    Attributes:
        name: Its name in rows, reports and events.
        h: Scalar expression of the system's x, and of its t where the set moves.
        class_k: γ₁ … γ_{r+1} for relative degree r; γ_{r+1} acts in the continuous law only. A number stands for a
            linear one with that gain.
        derivative_bounds: Bounds of the first r + 2 time derivatives of h, for one whose derivatives are too long to be
            enclosed; if they are not given, they are enclosed.
    """

    name: str
    h: ca.SX
    class_k: tuple[ClassK, ...]
    derivative_bounds: DerivativeBounds | None = None

    def __post_init__(self) -> None:
        """Take numbers for what they stand for, and refuse what stands for nothing."""
        if not isinstance(self.name, str):
            raise DesignError("barrier name", described(self.name), "a name")
        part = f"barrier {self.name!r}"
        if not isinstance(self.derivative_bounds, DerivativeBounds | None):
            raise DesignError(
                f"{part} derivative_bounds", described(self.derivative_bounds), "DerivativeBounds, or None"
            )
        object.__setattr__(self, "h", as_column(f"{part} h", self.h))
        object.__setattr__(self, "class_k", class_k_functions(f"{part} class_k", self.class_k))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BarrierChain:
    """The chain of one barrier on one system, or of one of the parts that its minima are made of.

    ψ₀ = h, ψᵢ = ψ̇ᵢ₋₁ + γᵢ(ψᵢ₋₁); ψ_r is the first to contain u. Of a maximum it is the chain of the branch that
    holds best: whose least of ψ₀ … ψ_{r−1} is the largest.

    Attributes:
        barrier: Where it comes from; a part is numbered, for example ``room[2]``.
        system: The plant that it is derived on.
        psi: ψ₀(x, t) … ψ_r(x, u, t), scalar expressions.
        reach: How the input reaches ψ_r.
        alternatives: Chains of all branches of a maximum; none where there is nothing to choose.
    """

    barrier: Barrier
    system: System
    psi: tuple[ca.SX, ...]
    reach: InputReach
    alternatives: tuple["BarrierChain", ...] = ()

    @property
    def relative_degree(self) -> int:
        """r, the number of time derivatives after which u appears."""
        return len(self.psi) - 1

    @property
    def last_class_k(self) -> ClassK:
        """γ_{r+1}, which the continuous law puts on ψ_r."""
        return self.barrier.class_k[self.relative_degree]

    @property
    def branches(self) -> tuple["BarrierChain", ...]:
        """Chains of smooth functions: the alternatives, or itself alone."""
        return self.alternatives or (self,)

    def on_member(self, system: System, name: str) -> "BarrierChain":
        """Return the chain on a plant that differs from this one in what ψ_r alone contains.

        Args:
            system: The plant.
            name: Of the barrier there.
        """
        barrier = replace(self.barrier, name=name)
        if self.alternatives:
            others = tuple(branch.on_member(system, name) for branch in self.alternatives)
            last = chosen_of(others, [branch.psi[-1] for branch in others])
        else:
            others = ()
            last = system.rate(self.psi[-2]) + barrier.class_k[self.relative_degree - 1](self.psi[-2])
        return replace(self, barrier=barrier, system=system, psi=(*self.psi[:-1], last), alternatives=others)

    def chosen(self, values: Sequence[ca.SX]) -> ca.SX:
        """Return the value that belongs to the branch which holds best at x and t, scalar.

        Args:
            values: One for each of the branches, scalars.
        """
        return chosen_of(self.branches, values)


def chosen_of(branches: Sequence[BarrierChain], values: Sequence[ca.SX]) -> ca.SX:
    """Return the value of the branch whose least of ψ₀ … ψ_{r−1} is the largest, the first of equals, scalar."""
    levels = [reduce(ca.fmin, branch.psi[:-1]) for branch in branches]
    best, value = levels[0], values[0]
    for level, other in zip(levels[1:], values[1:], strict=True):
        value = ca.if_else(level > best, other, value)
        best = ca.fmax(best, level)
    return value


def derive_chains(system: System, barrier: Barrier, reserve: Reserve | None = None) -> tuple[BarrierChain, ...]:
    """Find the relative degree of a barrier and derive its chains: one, or one for each part of a minimum.

    Args:
        system: The plant.
        barrier: h and its class-K functions, which all parts share.
        reserve: What ψ₁ … ψ_{r−1} are lessened by, where the plant may not follow its model.

    Returns:
        The chains, each with as many ψ as its relative degree asks for, plus ψ₀. Parts that are positive numbers have
        none.

    Raises:
        ShapeError: h is not a scalar.
        RelativeDegreeError: u does not appear within n derivatives.
        DesignError: The number of class-K functions is not r + 1, or there is a kink where a slope is needed.
    """
    part = f"barrier {barrier.name!r} h"
    system.require_state_function(part, barrier.h, 1, may_move=True)
    require_no_jumps(part, barrier.h)
    rows = smooth_parts(part, barrier.h)
    if len(rows) > 1 or len(rows[0]) > 1:
        rows = tuple(row for row in (_undecided(part, row) for row in rows) if row)
    if barrier.derivative_bounds is not None and (len(rows) > 1 or len(rows[0]) > 1):
        allowed = "a barrier for each of its parts, where the bounds of their derivatives are given"
        raise DesignError(part, "a minimum or maximum of several parts", allowed)
    if not rows:
        raise DesignError(part, f"{barrier.h}, which is never negative", "a function that is negative somewhere")
    if len(rows) == 1:
        return (_chain_of_row(system, barrier, rows[0], reserve),)
    chains = tuple(
        _chain_of_row(system, replace(barrier, name=f"{barrier.name}[{i}]"), row, reserve, is_part=True)
        for i, row in enumerate(rows, 1)
    )
    most = 1 + max(chain.relative_degree for chain in chains)
    if len(barrier.class_k) != most:
        raise other_number(f"barrier {barrier.name!r}", len(barrier.class_k), most)
    return chains


def derive_chain(system: System, barrier: Barrier) -> BarrierChain:
    """Derive the chain of a barrier that has one, as ``derive_chains`` does.

    Raises:
        DesignError: h is a minimum of several parts, or anything that ``derive_chains`` refuses.
    """
    chains = derive_chains(system, barrier)
    if len(chains) > 1:
        raise DesignError(f"barrier {barrier.name!r} h", f"{len(chains)} parts", "one; derive_chains derives all parts")
    return chains[0]


def _undecided(part: str, row: Sequence[ca.SX]) -> tuple[ca.SX, ...]:
    """Return the branches of a row that may hold or not; none where one always holds."""
    numbers = [float(branch) for branch in row if branch.is_constant()]
    if any(number >= 0.0 for number in numbers):
        return ()
    if len(numbers) == len(row):
        raise DesignError(part, f"a part that is {max(numbers):g} everywhere", "a function that is positive somewhere")
    return tuple(branch for branch in row if not branch.is_constant())


def _chain_of_row(
    system: System, barrier: Barrier, row: Sequence[ca.SX], reserve: Reserve | None, *, is_part: bool = False
) -> BarrierChain:
    """Return the chain of a maximum of smooth branches, which may be a part of a minimum."""
    smooth = [without_singular_points(branch) for branch in row]
    whole = barrier if smooth[0] is barrier.h else replace(barrier, h=reduce(ca.fmax, smooth))
    if len(smooth) == 1:
        return _derive(system, whole, reserve, is_part=is_part)
    branches = tuple(_derive(system, replace(whole, h=h), reserve, is_part=True) for h in smooth)
    require_one_degree(f"barrier {barrier.name!r}", [branch.relative_degree for branch in branches])
    most = branches[0].relative_degree + 1
    if len(barrier.class_k) != most and not is_part:
        raise other_number(f"barrier {barrier.name!r}", len(barrier.class_k), most)
    # They share their class-K functions, whose number follows from the relative degree.
    levels = range(most)
    psi = tuple(chosen_of(branches, [branch.psi[k] for branch in branches]) for k in levels)
    weakest = min((branch.reach for branch in branches), key=lambda reach: reach.ratio)
    return BarrierChain(barrier=whole, system=system, psi=psi, reach=weakest, alternatives=branches)


def _derive(system: System, barrier: Barrier, reserve: Reserve | None, *, is_part: bool) -> BarrierChain:
    """Return the chain of a smooth h; a part of a minimum takes the first of its class-K functions."""
    part = f"barrier {barrier.name!r}"
    psi = [barrier.h]
    unshaped = barrier.h
    gammas = iter(barrier.class_k)
    reach: InputReach | None = None
    is_contained = False
    while reach is None:
        if len(psi) > system.n:
            raise RelativeDegreeError(barrier.name, system.n, is_contained=is_contained)
        if ca.depends_on(psi[-1], system.u):  # below the relative degree rounding alone is left of u
            psi[-1], unshaped = ca.substitute([psi[-1], unshaped], [system.u], [ca.SX.zeros(system.m)])
        if reserve is not None and len(psi) > 1:
            psi[-1] -= reserve(psi[-2])
        require_slope(part, unshaped, len(psi) - 1)
        gamma = next(gammas, None)
        rate = system.rate(psi[-1])
        unshaped = system.rate(unshaped)
        is_contained = is_contained or ca.depends_on(unshaped, system.u)
        psi.append(rate if gamma is None else rate + gamma(psi[-1]))
        reach = reach_of(system, unshaped, len(psi) - 1, 1.0 if gamma is None else gamma.gain)
    require_effect(part, reach)
    wanted = len(psi)
    if is_part and len(barrier.class_k) > wanted:
        barrier = replace(barrier, class_k=barrier.class_k[:wanted])
    if len(barrier.class_k) != wanted:
        raise other_number(part, len(barrier.class_k), wanted)
    return BarrierChain(barrier=barrier, system=system, psi=tuple(psi), reach=reach)
