"""Rows that pull the input along one direction: each may have the push of the other."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_filter import BatchFilter
from passafe_services.tools.review.plant_evaluator import FloatArray

PARALLEL: Final = 1e-6
"""Difference of a cosine from 1 below which two unit gradients count as one direction."""


def pushed_alike(batch: BatchFilter, dual: FloatArray) -> NDArray[np.bool_]:
    """Return which rows may have their push from a parallel one, or that one theirs, shape (rows, size).

    The rows of one barrier for several members of an uncertain plant differ by a factor, which the length of the
    gradient takes out: which of them pushes makes no difference to the input. It makes one to the gap, of multiplier
    times margin; the certificate accepts gaps relative to 1 + ‖z‖², in which a relaxed soft row is large.

    Args:
        batch: Decisions that were made anew.
        dual: Logged multipliers, shape (rows, size).
    """
    count, size = dual.shape
    gradients = batch.program.G[: len(batch.evaluation.u_plus), :count, :size]
    gap = dual * np.maximum(batch.evaluation.margins[:count, :size], 0.0)
    square = np.square(batch.part("z")[:, :size]).sum(axis=0)
    is_accepted = gap <= batch.core.design.tolerance.gap * (1.0 + square)
    found = np.zeros((count, size), dtype=np.bool_)
    for row in range(count):
        cosines = np.einsum("ke,kce->ce", gradients[:, row], gradients)
        alike = (cosines >= 1 - PARALLEL) & is_accepted & is_accepted[row]
        alike[row] = False
        found |= alike
    return found
