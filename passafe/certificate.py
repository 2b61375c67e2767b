"""The certificate of an answer in plain numbers, for programs that are solved outside the filter's fast path."""

from functools import lru_cache

import casadi as ca
import numpy as np

from passafe.quadratic_program import Tolerance, judging_function
from passafe.workspace import Array


def is_certified(G: Array, d: Array, z: Array, lam: Array, tolerance: Tolerance) -> bool:
    """Tell whether z and λ meet the optimality conditions of min ½‖z‖² subject to G z ≥ d.

    The residuals are those of ``certificate_residuals``. A NaN anywhere is refused.

    Args:
        G: Rows, shape (N, k).
        d: Bounds, shape (N,).
        z: Answer, shape (k,).
        lam: Its multipliers, shape (N,).
        tolerance: Largest residuals.
    """
    _, residuals = _judge(*G.shape)(G, d, z, lam)
    primal, dual, gap = np.asarray(residuals.full()).ravel()
    return bool(primal <= tolerance.residual and dual <= tolerance.residual and gap <= tolerance.gap)


@lru_cache(maxsize=16)
def _judge(rows: int, size: int) -> ca.Function:
    return judging_function(rows, size)
