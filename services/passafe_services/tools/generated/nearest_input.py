"""An input within limits near another, computed from the limits as they were drawn."""

from typing import Final

import numpy as np

from passafe.numerics.workspace import Array
from passafe_services.tools.generated.admissible_input import InputLimits

_HALVINGS: Final = 60


def nearest_input(wanted: Array, before: Array | None, limits: InputLimits, dt_s: float) -> Array:
    """Return the wanted input, cut to rate and magnitude axis by axis, then drawn towards the one before to the norm.

    Args:
        wanted: Shape (m,).
        before: Input in force until then; ``None`` if there was none: then no rate is limited.
        limits: The limits.
        dt_s: Period, s.
    """
    bound = np.array(limits.magnitude)
    low, high = -bound, bound
    if limits.rate_per_s is not None and before is not None:
        step = dt_s * np.array(limits.rate_per_s)
        low, high = np.maximum(low, before - step), np.minimum(high, before + step)
    cut = np.clip(wanted, low, high)
    if limits.norm is None or np.linalg.norm(cut) <= limits.norm:
        return cut
    origin, share = np.zeros_like(cut) if before is None else before, (0.0, 1.0)
    for _ in range(_HALVINGS):
        middle = sum(share) / 2
        is_short = np.linalg.norm(origin + middle * (cut - origin)) <= limits.norm
        share = (middle, share[1]) if is_short else (share[0], middle)
    return np.asarray(origin + share[0] * (cut - origin))
