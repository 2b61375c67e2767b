"""Convert wall time to plant time, for messages that tell no plant time."""

from array import array

import numpy as np

from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray

STRIDE = 16
"""Of so many states one is noted; between them the plant's clock is as even as the wall clock."""


class PlantTimeline:
    """Wall times of plant states, and the plant time at any other wall time."""

    def __init__(self) -> None:
        self._wall_ns = array("q")
        self._plant_ns = array("q")

    def add(self, wall_ns: IntArray, plant_ns: IntArray) -> None:
        """Note states: wall time at which each was sent and its plant time, ns, shape (N,)."""
        self._wall_ns.extend(wall_ns[::STRIDE].tolist())
        self._plant_ns.extend(plant_ns[::STRIDE].tolist())

    def plant_s(self, wall_ns: IntArray) -> FloatArray:
        """Return plant times, s, for wall times, ns; before the first state and after the last, at its rate."""
        if not self._wall_ns:
            return np.zeros(wall_ns.shape)
        order = np.argsort(np.asarray(self._wall_ns), kind="stable")
        known = np.asarray(self._wall_ns)[order]
        plant = np.asarray(self._plant_ns)[order]
        origin = int(known[0])
        wall_s = (wall_ns - origin) * 1e-9
        known_s, plant_s = (known - origin) * 1e-9, plant * 1e-9
        inside: FloatArray = np.interp(wall_s, known_s, plant_s)
        beyond: FloatArray = np.minimum(wall_s - known_s[0], 0.0) + np.maximum(wall_s - known_s[-1], 0.0)
        return inside + beyond
