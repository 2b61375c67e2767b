"""Interface of the functions with which a review judges a run from its states."""

from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]


class PlantEvaluator(Protocol):
    """Functions of one scenario, each for many samples at once, one column per sample."""

    def h(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return barrier values in the scenario's order, shape (barriers, N), for x (n, N) and plant time t_s (N,)."""
        ...

    def power_margin(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return the power margin h_u(x, u) = yᵀu − L_fV(x, u), shape (N,), for x (n, N) and u (m, N)."""
        ...

    def flow(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the state ``duration_s`` after x with u held, shape (n, N), for x (n, N) and u (m, N)."""
        ...
