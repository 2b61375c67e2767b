"""Rows that pull the input along one direction and bind at once: each may have the push of the other."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_filter import BatchFilter

BINDS: Final = 1e-2
"""Relative margin below which a row may bind in another accepted answer: its multiplier is small, but not zero."""

PARALLEL: Final = 1e-6
"""Difference of a cosine from 1 below which two unit gradients count as one direction."""


def pushed_alike(batch: BatchFilter, size: int) -> NDArray[np.bool_]:
    """Return which rows may have the push of a parallel one, shape (rows, size).

    The rows of one barrier for several members of an uncertain plant differ by a factor, which the length of the
    gradient takes out: where they nearly coincide, the answer does not depend on which of them pushes.
    """
    count = batch.constraints
    u = batch.evaluation.u_plus[:, :size]
    gradients = batch.program.G[: u.shape[0], :count, :size]
    binds = batch.evaluation.margins[:count, :size] <= BINDS * (1 + np.abs(u).max(axis=0, initial=0.0))
    found = np.zeros((count, size), dtype=np.bool_)
    for row in range(count):
        cosines = np.einsum("ke,kce->ce", gradients[:, row], gradients)
        alike = (cosines >= 1 - PARALLEL) & binds & binds[row]
        alike[row] = False
        found |= alike
    return found
