"""The closed-form solution of min ½‖z‖² subject to G z ≥ d for at most two rows: the oracle for any solver.

Floating-point numbers are integers over a power of two, so the active sets are tried and judged in exact arithmetic:
there is no tolerance in here that could hide an error, and parallel, duplicated and zero rows need no case of their
own. A minimiser always has multipliers on linearly independent rows, so active sets with a singular Gram matrix are
left out.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Row = list[int]


class Minimiser(NamedTuple):
    """z and its multipliers λ, each rounded once to floating point."""

    z: NDArray[np.float64]
    lam: NDArray[np.float64]


def solve_exactly(G: ArrayLike, d: ArrayLike) -> Minimiser | None:
    """Return the minimiser and its multipliers, or ``None`` where the rows conflict.

    Args:
        G: At most two rows, shape (N, k), finite.
        d: Bounds, shape (N,), finite.
    """
    rows, bounds, scale = _as_integers(np.asarray(G, dtype=float), np.asarray(d, dtype=float))
    for weights, denominator in _stationary_points(rows, bounds):
        z = [sum(weight * row[i] for weight, row in zip(weights, rows, strict=True)) for i in range(len(rows[0]))]
        kept = all(_dot(row, z) >= bound * denominator for row, bound in zip(rows, bounds, strict=True))
        if kept and min(weights) >= 0:
            lam = [weight * scale / denominator for weight in weights]
            return Minimiser(np.array([value / denominator for value in z]), np.array(lam))
    return None


def _as_integers(G: NDArray[np.float64], d: NDArray[np.float64]) -> tuple[list[Row], Row, int]:
    """Rows and bounds times one power of two that makes all of them whole, and that power."""
    ratios = [[float(value).as_integer_ratio() for value in (*row, bound)] for row, bound in zip(G, d, strict=True)]
    scale = max(denominator for row in ratios for _, denominator in row)
    whole = [[numerator * (scale // denominator) for numerator, denominator in row] for row in ratios]
    return [row[:-1] for row in whole], [row[-1] for row in whole], scale


def _stationary_points(rows: Sequence[Row], bounds: Row) -> Iterator[tuple[Row, int]]:
    """(weights, denominator > 0) with z = Σ weightᵢ rowᵢ / denominator, for every active set with independent rows."""
    yield [0] * len(rows), 1
    for i, row in enumerate(rows):
        if square := _dot(row, row):
            yield [bounds[i] if j == i else 0 for j in range(len(rows))], square
    if len(rows) > 1:
        first, second = rows
        a, b, c = _dot(first, first), _dot(first, second), _dot(second, second)
        if determinant := a * c - b * b:
            yield [c * bounds[0] - b * bounds[1], a * bounds[1] - b * bounds[0]], determinant


def _dot(a: Row, b: Row) -> int:
    return sum(p * q for p, q in zip(a, b, strict=True))
