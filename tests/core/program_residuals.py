"""The residuals of an answer to a program of any shape."""

from functools import lru_cache

from passafe.certificate import ResidualEvaluation, Residuals
from passafe.numerics.workspace import Array


def residuals_of(G: Array, d: Array, z: Array, lam: Array) -> Residuals[float]:
    """Return the residuals of z and λ for G z ≥ d."""
    return _evaluation(*G.shape).of(G, d, z, lam)


@lru_cache(maxsize=16)
def _evaluation(rows: int, size: int) -> ResidualEvaluation:
    return ResidualEvaluation(rows, size)
