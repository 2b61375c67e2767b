"""Outputs and energies of states that were read, not computed."""

from collections.abc import Sequence
from typing import Final

from passafe_protocol.messages import Vector

from passafe.numerics.workspace import BlockLayout, Workspace, dense_function
from passafe.sampled_plant import Sample, SampledPlant

_HALF: Final = 0.5


class PortAccount:
    """Accounts for the energy that crosses the port, by the model's output and storage at the states read.

    Between two states the power is taken as linear in time: the model's own motion is not assumed.
    """

    def __init__(self, plant: SampledPlant) -> None:
        """Compile the model's output, storage and power.

        Args:
            plant: Model of the robot.
        """
        system = plant.system
        sizes = {"x": system.n, "u": system.m, "y": system.y.numel(), "stored": 1, "power": 1}
        self._space = space = Workspace(BlockLayout.of(sizes))
        results = [system.y, plant.V, system.power]
        function = dense_function("port", [system.x, system.u], results)
        self._evaluate = space.bind(function, ["x", "u"], ["y", "stored", "power"])
        self._write = space.span_writer(("x", "u"))
        self._read_y = space.reader("y")
        self._read_stored, self._read_power = space.reader("stored"), space.reader("power")

    def sample(self, before: Sequence[float], u: Vector, x: Vector, elapsed_s: float) -> Sample:
        """Return outputs and energies at x, after u was in force since the state before.

        Args:
            before: State before, n numbers.
            u: Input in force since then, m numbers.
            x: State now, n numbers.
            elapsed_s: Time between them, s.
        """
        self._write(*before, *u)
        self._evaluate()
        (begun_w,) = self._read_power()
        self._write(*x, *u)
        self._evaluate()
        (stored_j,), (ended_w,) = self._read_stored(), self._read_power()
        return Sample(x, self._read_y(), stored_j, _HALF * elapsed_s * (begun_w + ended_w), 0.0)
