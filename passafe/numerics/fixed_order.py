"""Linear algebra of small dense matrices, to the same last bit on every processor.

NumPy's and SciPy's ``@``, ``linalg`` and ``optimize`` call BLAS, whose kernels are chosen for the processor and add in
orders of their own: a decision made with them replays on the same kind of processor only. What is added here is added
by ``np.einsum`` and ``np.add.reduce``, whose order is that of the build (``docs/decisions/0040-fixed-order.md``).
"""

from collections.abc import Mapping
from math import frexp, ldexp, sqrt
from typing import Final

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array

TERMS: Final = 16
"""Terms of the series of an exponential, whose argument is scaled to a half: the rest is below rounding."""

SQUARINGS: Final = 40
"""Squarings of a matrix until its size tells its spectral radius, which it exceeds by at most √n·κ to the 2⁻⁴⁰."""

GAIN_SQUARINGS: Final = 24
"""The same for AᵀA, whose κ is one: 10⁻⁷ too large for any shape."""

TINY: Final = 1e-300
"""Size of a matrix below which it counts as zero."""

SMALLEST: Final = 1e-14
"""Part of a column that the columns before leave, relative to the largest, which counts as rounding."""

BALANCE_SWEEPS: Final = 32
UNBALANCED: Final = 0.95
"""Share of the sum of a row's and a column's size below which balancing them counts (Parlett & Reinsch 1969)."""

_SUBSCRIPTS: Final[Mapping[tuple[int, int], str]] = {(1, 1): "i,i", (1, 2): "i,ij->j", (2, 1): "ij,j->i"}


def inner(a: Array, b: Array) -> float:
    """Return aᵀb of two vectors."""
    return float(np.add.reduce(a * b))


def length(a: Array) -> float:
    """Return ‖a‖ of a vector."""
    return sqrt(np.add.reduce(a * a))


def product(A: Array, B: Array) -> Array:
    """Return A B of matrices, of stacks of matrices, or of vectors on either side."""
    return np.asarray(np.einsum(_SUBSCRIPTS.get((A.ndim, B.ndim), "...ij,...jk->...ik"), A, B))


def exponential(A: Array) -> Array:
    """Return e^A by its series, scaled and squared (Higham 2008, section 10.3).

    Args:
        A: Shape (n, n).
    """
    one = np.eye(len(A))
    squarings = max(0, frexp(float(np.abs(A).sum(axis=0).max(initial=0.0)))[1] + 1)
    scaled, power = A * ldexp(1.0, -squarings), one
    for k in range(TERMS, 0, -1):
        power = one + product(scaled, power) / k
    for _ in range(squarings):
        power = product(power, power)
    return power


def spectral_radius(A: Array) -> float:
    """Return the largest magnitude of an eigenvalue, from above, by the sizes of the powers of A (Gelfand 1941).

    Args:
        A: Shape (n, n), finite.
    """
    sizes: list[float] = []
    for _ in range(SQUARINGS):
        sizes.append(length(A.ravel()))
        A = A / max(sizes[-1], TINY)
        A = product(A, A)
    radius = length(A.ravel())
    for size in reversed(sizes):
        radius = size * sqrt(radius)
    return radius


def largest_gain(size: int) -> ca.Function:
    """Return the function from A, shape (size, size), to ‖A‖₂, from above; it is a hundred times as fast as NumPy here.

    By the powers of AᵀA, as ``spectral_radius``.
    """
    A = ca.MX.sym("A", size, size)
    power, sizes = A.T @ A, []
    for _ in range(GAIN_SQUARINGS):
        sizes.append(ca.norm_fro(power))
        power /= ca.fmax(sizes[-1], TINY)
        power = power @ power
    square = ca.norm_fro(power)
    for each in reversed(sizes):
        square = each * ca.sqrt(square)
    return ca.Function("largest_gain", [A], [ca.sqrt(square)])


def cholesky(P: Array) -> Array:
    """Return the upper triangular R with RᵀR = P.

    Args:
        P: Symmetric and positive definite, shape (n, n).
    """
    R = np.zeros_like(P)
    for k in range(len(P)):
        row = P[k, k:] - product(R[:k, k], R[:k, k:])
        R[k, k:] = row / sqrt(row[0])
    return R


def balancing(A: Array) -> Array:
    """Return powers of two t, shape (n,), for which rows and columns of A·t/t[:, None] are about as long.

    The method of Parlett & Reinsch (1969) with lengths, as LAPACK's ``gebal``.
    """
    balanced, scale = A.copy(), np.ones(len(A))
    for _ in range(BALANCE_SWEEPS):
        before = scale.copy()
        for i in range(len(A)):
            column, row, factor = length(balanced[:, i]), length(balanced[i]), 1.0
            while 0.0 < 2 * column * factor < row / factor:
                factor *= 2
            while column * factor >= 2 * row / factor > 0.0:
                factor /= 2
            if column * factor + row / factor < UNBALANCED * (column + row):
                scale[i] *= factor
                balanced[:, i] *= factor
                balanced[i] /= factor
        if np.array_equal(scale, before):
            break
    return scale


def least_squares(A: Array, b: Array, smallest: float = SMALLEST) -> Array:
    """Return the shortest x for which ‖A x − b‖ is least.

    Args:
        A: Shape (m, n).
        b: Shape (m,) or (m, k), for k problems at once.
        smallest: Part of a column, relative to the largest, that counts as none of A.
    """
    Q, W, order = _orthogonal(A, smallest)
    asked = product(Q.T, b)
    if len(order) == A.shape[1]:
        x = np.zeros((len(order), *b.shape[1:]))
        for k in reversed(range(len(order))):
            x[order[k]] = (asked[k] - product(W[k], x)) / W[k, order[k]]
        return x
    V, R, order = _orthogonal(W.T, 0.0)
    y = np.zeros((len(order), *b.shape[1:]))
    for k, column in enumerate(order):
        y[k] = (asked[column] - product(R[:k, column], y[:k])) / R[k, column]
    return product(V, y)


def solution(A: Array, b: Array) -> Array | None:
    """Return x with A x = b, or ``None`` where A is singular.

    Args:
        A: Shape (n, n).
        b: Shape (n,) or (n, k).
    """
    return least_squares(A, b) if len(_orthogonal(A, SMALLEST)[2]) == len(A) else None


def _orthogonal(A: Array, smallest: float) -> tuple[Array, Array, list[int]]:
    """Return Q and W with A = Q W and QᵀQ = 1, and the columns of A in the order in which they make up Q.

    Gram and Schmidt's, with the largest column that is left next, and each made orthogonal twice (Giraud et al. 2005).
    """
    m, n = A.shape
    rest, largest = A.copy(), 0.0
    Q, W, order = np.zeros((m, min(m, n))), np.zeros((min(m, n), n)), list[int]()
    for k in range(min(m, n)):
        squares = np.add.reduce(rest * rest, axis=0)
        column = int(squares.argmax())
        size = sqrt(squares[column])
        largest = largest or size
        if not size > smallest * largest:
            break
        q = rest[:, column] / size
        if order:
            q -= product(Q[:, :k], product(q, Q[:, :k]))
            q /= length(q)
        Q[:, k] = q
        W[k] = product(q, rest)
        rest -= np.multiply.outer(q, W[k])
        rest[:, column] = 0.0
        order.append(column)
    return Q[:, : len(order)], W[: len(order)], order
