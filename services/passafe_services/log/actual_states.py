"""Actual states of the robot, from the columns of plant states."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from passafe_services.log.message_block import MessageBlock

STATE_PATHS: Final = ("x", "true_x")
"""Columns that ``actual_states`` reads."""


def actual_states(block: MessageBlock, width: int) -> NDArray[Any]:
    """Return the true states where the plant tells them, else those read, as ``PlantState.actual_x``.

    Args:
        block: Plant states.
        width: Length n of a state.

    Returns:
        Shape (n, N); NaN where a message has a state of another length.
    """
    true = block.ragged("true_x")
    found: NDArray[Any] = np.where(true.counts == width, true.matrix(width).T, block.matrix("x", width))
    return found
