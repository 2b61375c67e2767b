"""Control barrier functions h(x, t) and the chain ψ₀ … ψ_r that carries them to the input.

Paper, section 3.1 and remark 2; high-order control barrier functions as in Xiao & Belta (2019).
"""

from dataclasses import dataclass

import casadi as ca

from passafe.class_k import ClassK, class_k_functions
from passafe.errors import DesignError, RelativeDegreeError
from passafe.expressions import as_column
from passafe.system import System

ROUNDING = 1e-12
"""Rounding error of a gradient that cancels, at arguments of the order of one."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Barrier:
    """A safe set {x : h(x, t) ≥ 0} and the class-K functions of its chain.

    Attributes:
        name: Its name in rows, reports and events.
        h: Scalar expression of the system's x, and of its t where the set moves.
        class_k: γ₁ … γ_{r+1} for relative degree r; γ_{r+1} acts in the continuous law only. A number stands for a
            linear one with that gain.
    """

    name: str
    h: ca.SX
    class_k: tuple[ClassK, ...]

    def __post_init__(self) -> None:
        """Take numbers for what they stand for, and refuse what stands for nothing."""
        part = f"barrier {self.name!r}"
        object.__setattr__(self, "h", as_column(f"{part} h", self.h))
        object.__setattr__(self, "class_k", class_k_functions(f"{part} class_k", self.class_k))


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BarrierChain:
    """The chain of one barrier on one system.

    ψ₀ = h, ψᵢ = ψ̇ᵢ₋₁ + γᵢ(ψᵢ₋₁); ψ_r is the first to contain u.

    Attributes:
        barrier: Where it comes from.
        psi: ψ₀(x, t) … ψ_r(x, u, t), scalar expressions.
    """

    barrier: Barrier
    psi: tuple[ca.SX, ...]

    @property
    def relative_degree(self) -> int:
        """r, the number of time derivatives after which u appears."""
        return len(self.psi) - 1

    @property
    def last_class_k(self) -> ClassK:
        """γ_{r+1}, which the continuous law puts on ψ_r."""
        return self.barrier.class_k[self.relative_degree]


def derive_chain(system: System, barrier: Barrier) -> BarrierChain:
    """Find the relative degree of a barrier and derive its chain.

    Args:
        system: The plant.
        barrier: h and its class-K functions.

    Returns:
        The chain, with as many ψ as the relative degree asks for, plus ψ₀.

    Raises:
        ShapeError: h is not a scalar.
        RelativeDegreeError: u does not appear within n derivatives.
        DesignError: The number of class-K functions is not r + 1.
    """
    part = f"barrier {barrier.name!r}"
    system.require_state_function(f"{part} h", barrier.h, 1, may_move=True)
    psi = [barrier.h]
    unshaped = barrier.h
    gammas = iter(barrier.class_k)
    while len(psi) == 1 or not _depends_on_input(system, unshaped):
        if len(psi) > system.n:
            raise RelativeDegreeError(barrier.name, system.n)
        gamma = next(gammas, None)
        rate = system.rate(psi[-1])
        unshaped = system.rate(unshaped)
        psi.append(rate if gamma is None else rate + gamma(psi[-1]))
    wanted = len(psi)
    if len(barrier.class_k) != wanted:
        raise DesignError(
            f"{part} class_k",
            f"{len(barrier.class_k)} functions",
            f"{wanted}: relative degree {wanted - 1} and one more",
        )
    return BarrierChain(barrier=barrier, psi=tuple(psi))


def _depends_on_input(system: System, expression: ca.SX) -> bool:
    """Return whether an expression depends on u, after cancellation.

    Symbolic structure keeps terms such as 0·u; so the gradient is also evaluated, at states and inputs in
    general position, and an identical zero does not count.
    """
    gradient = ca.jacobian(expression, system.u)
    if gradient.nnz() == 0:
        return False
    evaluate = ca.Function("gradient", [system.x, system.u, system.t], [ca.densify(gradient)])
    probes = [
        scale * ca.DM([(0.37 + 0.11 * k + 0.29 * i) * (-1) ** (i + k) for i in range(system.n)])
        for scale in (1, 10, 100)
        for k in range(8)
    ]
    inputs = ca.DM([0.53 + 0.17 * j for j in range(system.m)])
    return any(float(ca.norm_inf(evaluate(x, inputs, time))) > ROUNDING for time in (0.0, 0.71) for x in probes)
