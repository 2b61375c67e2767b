"""The nearest point to the origin in each polyhedron of a batch: guesses that a certificate judges.

min ½‖z‖² subject to G z ≥ d with rows of unit length. A dual active-set method (Goldfarb & Idnani 1983) in closed form:
the origin; else the foot on the row that it misses most; else, with the row that this misses most, the foot on both or,
where the first row no longer pushes, on the second alone; and so on while rows are missed.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.numerics.workspace import Array

MISSED: Final = 1e-10
"""Violation from which a row counts as missed, relative to 1 + ‖z‖."""

Places = NDArray[np.intp]


class NearestPoints:
    """Holds rows and bounds of a batch of polyhedra and finds their nearest points.

    Attributes:
        rows: G, columns first, shape (k, M, count).
        bounds: d, shape (M, count).
    """

    def __init__(self, k: int, rows: int, count: int) -> None:
        """Make room.

        Args:
            k: Length of z.
            rows: M.
            count: Number of polyhedra.
        """
        self.rows: Array = np.zeros((k, rows, count))
        self.bounds: Array = np.zeros((rows, count))
        self._elements = np.arange(count)
        self._missing, self._product = np.empty((rows, count)), np.empty((rows, count))

    def find(self, z: Array, lam: Array) -> None:
        """Write a guess of every point and its multipliers; where it is wrong, the certificate refuses it.

        Args:
            z: Receives the points, shape (k, count).
            lam: Receives the multipliers, shape (M, count).
        """
        elements = self._elements
        first = self.bounds.argmax(axis=0)
        push_1 = np.maximum(self.bounds[first, elements], 0.0)
        g_1 = self.rows[:, first, elements]
        np.multiply(g_1, push_1, z)
        lam.fill(0.0)
        second, missed = self._most_missed(z)
        more = missed > MISSED * (1.0 + push_1)
        g_2, bound_1, bound_2 = (
            self.rows[:, second, elements],
            self.bounds[first, elements],
            self.bounds[second, elements],
        )
        c = (g_1 * g_2).sum(axis=0)
        det = 1.0 - c * c
        both_1, both_2 = (bound_1 - c * bound_2) / det, (bound_2 - c * bound_1) / det
        kept = both_1 > 0.0
        push_1 = np.where(more, np.where(kept, both_1, 0.0), push_1)
        push_2 = np.where(more, np.where(kept, both_2, bound_2), 0.0)
        lam[first, elements] = push_1
        lam[second, elements] += push_2
        np.multiply(g_1, push_1, z)
        z += g_2 * push_2

    def _most_missed(self, z: Array) -> tuple[Places, Array]:
        missing, product = self._missing, self._product
        missing[:] = self.bounds
        for column, coordinate in zip(self.rows, z, strict=True):
            np.multiply(column, coordinate, product)
            np.subtract(missing, product, missing)
        place = missing.argmax(axis=0)
        return place, missing[place, self._elements]
