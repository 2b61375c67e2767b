"""The certificate of an answer: its residuals, and the one function that accepts it.

An answer to min ½‖z‖² subject to G z ≥ d is a pair (z, λ). Whichever solver computed it, it is used only if ``accepts``
is true of the residuals of the optimality conditions.
"""

from dataclasses import dataclass
from typing import overload

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.numerics.stage import Stage, T
from passafe.numerics.workspace import Array, BlockLayout, Workspace, expressions_by_name, named_function


@dataclass(frozen=True, kw_only=True, slots=True)
class Tolerance:
    """Residuals up to which an answer is accepted, relative to 1 + ‖z‖ (gap: 1 + ‖z‖²).

    Attributes:
        residual: Largest primal and dual residual.
        gap: Largest duality gap. A feasible z then lies within √(2·gap) of the true minimiser, because the
            objective is strongly convex with modulus 1.
    """

    residual: float = 1e-6
    gap: float = 1e-6


class Residuals(Stage[T], frozen=True, eq=False, gc=False):
    """Relative residuals of the optimality conditions; all three vanish exactly at the minimiser and its multipliers.

    Attributes:
        primal: Largest violation of G z ≥ d, over 1 + ‖z‖.
        dual: Largest of |z − Gᵀλ| and of −λ, over 1 + ‖z‖.
        gap: |½zᵀz − (λᵀd − ½‖Gᵀλ‖²)| over 1 + ‖z‖² (Boyd & Vandenberghe, section 5.5).
    """

    primal: T
    dual: T
    gap: T


@overload
def accepts(tolerance: Tolerance, residuals: Residuals[float]) -> bool: ...
@overload
def accepts(tolerance: Tolerance, residuals: Residuals[Array]) -> NDArray[np.bool_]: ...
def accepts(
    tolerance: Tolerance, residuals: Residuals[float] | Residuals[Array]
) -> bool | np.bool_ | NDArray[np.bool_]:
    """Return whether an answer with these residuals is accepted; one with a NaN among them is not.

    Args:
        tolerance: Largest residuals.
        residuals: Of one answer, or of every element of a batch.
    """
    largest = tolerance.residual
    return (residuals.primal <= largest) & (residuals.dual <= largest) & (residuals.gap <= tolerance.gap)


def certificate_residuals(z: ca.SX, lam: ca.SX, G: ca.SX, d: ca.SX) -> Residuals[ca.SX]:
    """Return the residuals as scalar expressions. A NaN in any argument makes one of them NaN.

    Args:
        z: Decision, shape (k, 1).
        lam: Multipliers λ, shape (N, 1).
        G: Rows, shape (N, k).
        d: Bounds, shape (N, 1).
    """
    if d.numel() == 0:
        return Residuals(ca.SX(0), ca.norm_2(z), ca.sumsqr(z))
    scale = 1 + ca.norm_2(z)
    pull = G.T @ lam
    return Residuals(
        primal=ca.fmax(ca.mmax(d - G @ z), 0) / scale,
        dual=ca.fmax(ca.mmax(ca.fabs(z - pull)), -ca.mmin(lam)) / scale,
        gap=ca.fabs(ca.sumsqr(z) / 2 - ca.dot(lam, d) + ca.sumsqr(pull) / 2) / (1 + ca.sumsqr(z)),
    )


class ResidualEvaluation:
    """Evaluates the residuals of programs of one shape in plain numbers, outside of the filter's own block."""

    def __init__(self, rows: int, size: int) -> None:
        """Compile the residuals.

        Args:
            rows: N.
            size: k.
        """
        G, d = ca.SX.sym("G", rows, size), ca.SX.sym("d", rows)
        z, lam = ca.SX.sym("z", size), ca.SX.sym("lam", rows)
        found = certificate_residuals(z, lam, G, d)
        shapes: dict[str, int | tuple[int, ...]] = {"G": (rows, size), "d": rows, "z": size, "lam": rows}
        self._space = space = Workspace(BlockLayout.of(shapes | dict.fromkeys(Residuals.names(), 1)))
        self._given = tuple(space.view(name) for name in ("G", "d", "z", "lam"))
        arguments = {"G": G, "d": d, "z": z, "lam": lam}
        self._evaluate = space.bind(named_function("residuals", arguments, expressions_by_name(found)))
        self._read = space.scalar_reader(Residuals[float])

    def of(self, G: Array, d: Array, z: Array, lam: Array) -> Residuals[float]:
        """Return the residuals of an answer.

        Args:
            G: Rows, shape (N, k).
            d: Bounds, shape (N,).
            z: Answer, shape (k,).
            lam: Its multipliers, shape (N,).
        """
        for memory, array in zip(self._given, (G, d, z, lam), strict=True):
            memory[...] = array
        self._evaluate()
        return self._read()
