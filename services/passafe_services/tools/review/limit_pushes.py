"""Pushes of rows on an axis of the input which is at its limit: they may be the limit's as well."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_filter import BatchFilter
from passafe_services.tools.review.plant_evaluator import FloatArray

AT_LIMIT: Final = 1e-3
"""Relative distance to a limit below which an answer may count as being there."""


def axes_at_limits(batch: BatchFilter, size: int) -> NDArray[np.bool_]:
    """Return which axes of the input are at a limit, up to what two accepted answers differ by, shape (m, size)."""
    u, low, high = (part[:, :size] for part in (batch.evaluation.u_plus, batch.program.low, batch.program.high))
    return np.asarray(np.minimum(u - low, high - u) <= AT_LIMIT * (1 + np.abs(u)))


def unlike_pull(batch: BatchFilter, difference: FloatArray, dual: FloatArray) -> FloatArray:
    """Return by how much duals pull differently on the input: where rows or limits coincide, many are right."""
    if not difference.shape[0]:
        return np.zeros(difference.shape[1])
    size = difference.shape[1]
    pulls = np.abs(np.einsum("kce,ce->ke", batch.program.G[:, :, :size], difference))
    at_limit = axes_at_limits(batch, size)
    pulls[: at_limit.shape[0]][at_limit] = 0.0  # there the limit's own dual makes up for what rows do not pull
    found: FloatArray = np.maximum(pulls.max(axis=0), -dual.min(axis=0)) / (1 + np.abs(dual).max(axis=0))
    return found
