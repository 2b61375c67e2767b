"""Interface of the functions with which a review judges a run from its states."""

from collections.abc import Sequence
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]


class PlantEvaluator(Protocol):
    """Functions of one scenario, each for many samples at once, one column per sample."""

    def h(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return barrier values in the scenario's order, shape (barriers, N), for x (n, N) and plant time t_s (N,)."""
        ...

    def h_error(self, x: FloatArray, t_s: FloatArray, x_error: FloatArray) -> FloatArray:
        """Return bounds of the error of ``h``, shape (barriers, N): of its rounding, and of x wrong by x_error.

        x_error has the shape (N,) of every number of a state, or (n, N).
        """
        ...

    @property
    def protected(self) -> Sequence[str]:
        """Names of ψ₀ … ψ_{r−1} of every barrier; all are ≥ 0 in the set that the filter protects."""
        ...

    def psi(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return these values, shape (P, N), for x of shape (n, N) and plant time t_s, s, of shape (N,)."""
        ...

    def power_margin(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return the power margin h_u(x, u) = yᵀu − L_fV(x, u), shape (N,), for x (n, N) and u (m, N)."""
        ...

    def energy_gain(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return ∫h_u dt over ``duration_s`` after x with u held, J, shape (N,), for x (n, N) and u (m, N)."""
        ...

    def output(self, x: FloatArray) -> FloatArray:
        """Return outputs y, shape (m, N), for x of shape (n, N)."""
        ...

    def stored(self, x: FloatArray) -> FloatArray:
        """Return the stored energy V(x), J, shape (N,), for x of shape (n, N)."""
        ...

    def supplied(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return ∫yᵀu dt over ``duration_s`` after x with u held, J, shape (N,), for x (n, N) and u (m, N)."""
        ...

    def flow(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the state ``duration_s`` after x with u held, shape (n, N), for x (n, N) and u (m, N)."""
        ...

    def flow_error(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the estimated error of ``flow`` but for its rounding, shape (N,); 0 where it is exact."""
        ...
