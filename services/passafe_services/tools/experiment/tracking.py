"""Distance of a robot from where it would be at the same time without injected links."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from passafe.batch.batch_function import BatchFunction
from passafe.models.robot import Robot
from passafe.numerics.workspace import dense_function
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.trajectory import Trajectory


class Deviation(NamedTuple):
    """Distance ‖p − p_ref‖₂ over the times that both runs have, in the position's own unit.

    Attributes:
        rms: Root mean square.
        largest: Largest.
        final: At the last of these times.
    """

    rms: float
    largest: float
    final: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Tracking:
    """Position of a robot over plant time.

    Attributes:
        t_s: Plant time, s, increasing, shape (N,).
        position: Position, shape (d, N).
    """

    t_s: FloatArray
    position: FloatArray

    def deviation(self, other: "Tracking") -> Deviation | None:
        """Return how far the other one is from this one; ``None`` where they have no time in common."""
        _, here, there = np.intersect1d(self.t_s, other.t_s, assume_unique=True, return_indices=True)
        if not here.size:
            return None
        distance = np.linalg.norm(self.position[:, here] - other.position[:, there], axis=0)
        return Deviation(
            rms=float(np.sqrt(np.mean(np.square(distance)))),
            largest=float(distance.max()),
            final=float(distance[-1]),
        )


class Motion:
    """Takes a robot's position from its states."""

    def __init__(self, robot: Robot) -> None:
        function = dense_function("position", [robot.system.x], [robot.position])
        self._position = BatchFunction(function, by_casadi=True)

    def of(self, trajectory: Trajectory) -> Tracking:
        """Return where the robot was in a run."""
        if not trajectory.samples:
            return Tracking(t_s=trajectory.t_s, position=np.zeros((0, 0)))
        return Tracking(t_s=trajectory.t_s, position=self._position(trajectory.x)[0])
